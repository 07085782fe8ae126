"""Programs written for RLBench: `rlbench` and `pyrep` under their known names, as views on this package.

`install()` makes the names importable; `python -m rlbench_pin.compat program.py` and `RLBENCH_PIN_COMPAT=1` call it. It is
never done by default, and refused where the real packages are installed. The two packages lie in `packages/`, a folder that
`install()` appends to the module search path.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

from rlbench_pin.errors import RlbenchPinError

PACKAGES = Path(__file__).parent / "packages"
"""Folder with the packages `rlbench` and `pyrep`."""
NAMES = ("rlbench", "pyrep")


class RealPackageInstalled(RlbenchPinError, ImportError):
    """RLBench or PyRep is installed, so that their names are taken."""


def install() -> None:
    """Make `import rlbench` and `import pyrep` find the packages of this folder; calling it again changes nothing.

    Raises:
        RealPackageInstalled: One of the two names belongs to another package already.
    """
    for name in NAMES:
        spec = importlib.util.find_spec(name)
        origin = None if spec is None else spec.origin
        if origin is not None and not Path(origin).is_relative_to(PACKAGES):
            raise RealPackageInstalled(
                f"The real '{name}' is installed at {Path(origin).parent}, so its name cannot stand for rlbench_pin. "
                "Use a virtual environment without it, or import from rlbench_pin."
            )
    if str(PACKAGES) not in sys.path:
        sys.path.append(str(PACKAGES))
