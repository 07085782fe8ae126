"""What results were made with: versions of libraries, the commit of the checkout, the machine."""

from __future__ import annotations

import os
import platform
import subprocess
from pathlib import Path

from rlbench_pin.assets import ASSETS

_ROOT = ASSETS.parents[1]


def checkout_commit(root: Path = _ROOT) -> str:
    """Return the commit of the checkout that the package runs from, with ` changed` where files differ; empty outside of one."""
    if not (root / ".git").exists():
        return ""
    commit = _git(root, "rev-parse", "HEAD")
    return f"{commit} changed" if commit and _git(root, "status", "--porcelain", "--untracked-files=no") else commit


def _git(root: Path, *words: str) -> str:
    """Return what git answers; nothing where there is no git, or it refuses."""
    try:
        done = subprocess.run(["git", "-C", str(root), *words], capture_output=True, text=True, timeout=20.0, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip()


def machine() -> dict[str, str | int]:
    """Return what times depend on: the processor, how many of its cores there are, and the system."""
    return {"processor": _processor(), "cores": os.cpu_count() or 1, "system": platform.platform(terse=True)}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()
