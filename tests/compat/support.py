"""How tests run programs of users: in a process of their own, with or without the known names."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def environment(**variables: str) -> dict[str, str]:
    """Return the environment of a child: this work tree first on its search path, the layer's variable unset."""
    kept = {key: value for key, value in os.environ.items() if key != "RLBENCH_PIN_COMPAT"}
    path = os.pathsep.join([str(ROOT), *filter(None, [kept.get("PYTHONPATH", "")])])
    return {**kept, "PYTHONPATH": path, "OMP_NUM_THREADS": "1", **variables}


def python(
    *arguments: str | Path, cwd: Path | None = None, env: Mapping[str, str] | None = None, executable: str = sys.executable
) -> subprocess.CompletedProcess[str]:
    """Run python with arguments and return what it said."""
    return subprocess.run(
        [executable, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=600,
        cwd=cwd,
        env=dict(environment() if env is None else env),
    )


def compat(*arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run `python -m rlbench_pin.compat` with arguments."""
    return python("-m", "rlbench_pin.compat", *arguments, cwd=cwd)
