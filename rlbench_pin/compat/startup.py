"""Adds the packages to the module search path, for `install()` and for the start of Python with `RLBENCH_PIN_COMPAT=1`.

`rlbench_pin_compat.pth` executes this file when Python starts with the variable set. The file imports no part of rlbench_pin,
so that the start is fast, and a program may set variables such as `OMP_NUM_THREADS` before numpy is loaded.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

PACKAGES = Path(__file__).resolve().parent / "packages"
"""Folder with the packages `rlbench` and `pyrep`."""
NAMES = ("rlbench", "pyrep")
VARIABLE = "RLBENCH_PIN_COMPAT"
"""Environment variable: if it is neither empty nor `0`, Python adds the packages when it starts."""


def taken_name() -> str | None:
    """Return a message that names the other package with one of the names, and its path; None when both are free or ours."""
    for name in NAMES:
        found = sys.modules[name].__spec__ if name in sys.modules else importlib.util.find_spec(name)
        if found is None:
            continue
        folders = [Path(folder) for folder in found.submodule_search_locations or ()]
        places = [Path(found.origin).parent] if found.origin is not None else folders
        if not any(place.resolve().is_relative_to(PACKAGES) for place in places):
            return (
                f"The real '{name}' is installed at {places[0] if places else 'an unknown place'}, so its name cannot be used "
                "for rlbench_pin. Use a virtual environment without it, take the folder off the module search path, or "
                "import from rlbench_pin."
            )
    return None


def add_packages() -> None:
    """Append the folder with the packages to the module search path, once."""
    if str(PACKAGES) not in sys.path:
        sys.path.append(str(PACKAGES))


def start() -> None:
    """Add the packages when Python starts; if their names are taken, report that on stderr and start without them."""
    taken = taken_name()
    if taken is not None:
        sys.stderr.write(f"{VARIABLE}: {taken}\n")
        os.environ[VARIABLE] = "0"  # Python executes start-up files twice in a virtual environment
        return
    add_packages()
