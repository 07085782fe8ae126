"""Provenance of results: commit, machine, files of the policy, and action times."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from rlbench_pin.assets import ASSETS
from rlbench_pin.datasets.manifest import file_digest
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.evaluation.run.config import EvaluationConfig
from rlbench_pin.evaluation.run.episode import EpisodeOutcome

_ROOT = ASSETS.parents[1]
_FORMAT = 1


def checkout_commit() -> str:
    """Return the commit of the package's git checkout, with ` changed` if files differ; empty outside a checkout."""
    if not (_ROOT / ".git").exists():
        return ""
    commit = _git("rev-parse", "HEAD")
    return f"{commit} changed" if commit and _git("status", "--porcelain", "--untracked-files=no") else commit


def _git(*words: str) -> str:
    """Return the output of git in the folder of the package; empty if git is missing or fails."""
    try:
        done = subprocess.run(["git", "-C", str(_ROOT), *words], capture_output=True, text=True, timeout=20.0, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip()


def machine() -> dict[str, str | int]:
    """Return the processor, its number of cores, and the operating system."""
    return {"processor": _processor(), "cores": os.cpu_count() or 1, "system": platform.platform(terse=True)}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


def policy_digests(reference: str) -> dict[str, str]:
    """Return name -> SHA-256 of the files that a reference names: `file.py`, the file of `sb3:`, the files of a folder.

    A folder is from `lerobot:`, `ppo:` or `sac:FOLDER`, or an argument, as in `cloning?folder=models`. Imported modules,
    libraries and served policies are not included. The commit identifies built-in policies.

    Args:
        reference: Reference of the policy, see `find_policy`.
    """
    if reference.startswith(("unix:", "tcp:")):
        return {}
    name, _, query = reference.partition("?")
    values = [unquote(pair.partition("=")[2]) for pair in query.split("&") if pair]
    if reference.startswith(("openpi:", "vla-eval:")):  # the mapping may be a file; the commit identifies a preset
        return {str(file): file_digest(file) for text in values if text.endswith(".toml") for file in _files(text)}
    kind, _, rest = name.partition(":")
    named = [rest] if kind in ("sb3", "lerobot", "ppo", "sac") else []
    named += [f"{rest}.zip"] if kind == "sb3" else []
    named += [name.rpartition(":")[0]] if name.rpartition(":")[0].endswith(".py") else []
    found: dict[str, str] = {}
    for text in (*named, *values):
        for file in _files(text):
            found[str(file)] = file_digest(file)
    return found


def _files(text: str) -> list[Path]:
    """Return the file that a text names, or the sorted files of a folder; empty if there is neither."""
    path = Path(text)
    try:
        if text and path.is_file():
            return [path]
        return sorted(file for file in path.rglob("*") if file.is_file()) if text and path.is_dir() else []
    except (OSError, ValueError):  # a text that no path can be
        return []


def times_path(results: Path) -> Path:
    """Return the path of the action times of a results file: `x.times.json` next to `x.json`."""
    return results.with_name(f"{results.stem}.times.json")


def write_times(path: Path, config: EvaluationConfig, outcomes: Sequence[EpisodeOutcome]) -> Path:
    """Write the time per action of each task, and of all tasks, and return the path.

    Args:
        path: JSON file to write.
        config: Settings of the evaluation.
        outcomes: Outcomes of all episodes.

    Raises:
        StorageError: The disk cannot be written to.
    """
    tasks = dict.fromkeys(outcome.item.name for outcome in outcomes)
    content = {
        "format": _FORMAT,
        "policy": config.policy,
        "machine": machine(),
        "tasks": {task: _summary([o for o in outcomes if o.item.name == task]) for task in tasks},
        "all": _summary(outcomes),
    }
    return write_whole(path, (json.dumps(content, indent=1) + "\n").encode())


def _summary(outcomes: Sequence[EpisodeOutcome]) -> dict[str, float | int | None]:
    """Return the number of actions, and the median, 95th percentile and maximum of their times [s]."""
    times = np.array([t for outcome in outcomes for t in outcome.action_times])
    if not len(times):
        return {"actions": 0, "median_s": None, "p95_s": None, "max_s": None}
    values = {"median_s": np.median(times), "p95_s": np.quantile(times, 0.95), "max_s": times.max()}
    return {"actions": len(times), **{name: round(float(value), 6) for name, value in values.items()}}
