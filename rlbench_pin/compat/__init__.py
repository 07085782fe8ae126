"""Compatibility with programs written for RLBench: packages `rlbench` and `pyrep` as views on this package.

`install()` makes the names importable; `python -m rlbench_pin.compat program.py` and `RLBENCH_PIN_COMPAT=1 python program.py`
do the same for an unchanged program. This is never the default, and it raises an error if the real packages
are installed. The two packages are in `packages/`, a folder that `install()` appends to the module search path.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable

from rlbench_pin.compat.startup import NAMES, PACKAGES, add_packages, taken_name
from rlbench_pin.errors import RlbenchPinError

__all__ = ["NAMES", "PACKAGES", "RealPackageInstalled", "install"]


class RealPackageInstalled(RlbenchPinError, ImportError):
    """RLBench or PyRep is installed, so that their names are taken."""


def install() -> None:
    """Make `import rlbench` and `import pyrep` find the packages of this folder; calling it again changes nothing.

    Raises:
        RealPackageInstalled: One of the two names belongs to another package already.
    """
    taken = taken_name()
    if taken is not None:
        raise RealPackageInstalled(taken)
    add_packages()


def add_aliases(module: str, names: Iterable[str]) -> None:
    """Make `import <module>.<name>` work for module names of RLBench or PyRep; each name refers to `module` itself."""
    target = sys.modules[module]
    for name in names:
        vars(target)[name] = target
        sys.modules[f"{module}.{name}"] = target
