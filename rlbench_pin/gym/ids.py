"""The gymnasium ids of all tasks. They appear once both packages are imported, in whichever order, and import no task.

Importing `rlbench_pin` must stay light, so gymnasium is not imported for it: when it is there already, the ids are registered
at once, otherwise right after it has been imported by somebody else.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

MODES = ("state", "vision")
MAX_EPISODE_STEPS = 1000
"""Steps after which an episode is cut off; nearly twice the longest demonstration of the library in ticks."""

_LIBRARY = Path(__file__).parents[1] / "tasks" / "library"
_ENTRY_POINT = "rlbench_pin.gym.environment:GymnasiumEnv"
_GYMNASIUM = "gymnasium"


def gym_id(task: str, mode: str) -> str:
    """Return the id of a task: `rlbench_pin/reach_target-state-v0`."""
    return f"rlbench_pin/{task}-{mode}-v0"


def register_ids(gymnasium: ModuleType) -> None:
    """Register every task of the library with gymnasium; ids that are there already are left alone."""
    for file in sorted(_LIBRARY.glob("*.toml")):
        if file.with_suffix(".py").is_file():
            for mode in MODES:
                _register(gymnasium, file.stem, mode)


def _register(gymnasium: ModuleType, task: str, mode: str) -> None:
    name = gym_id(task, mode)
    if name not in gymnasium.registry:
        gymnasium.register(
            id=name,
            entry_point=_ENTRY_POINT,
            max_episode_steps=MAX_EPISODE_STEPS,
            kwargs={"task": task, "observation_mode": mode},
        )


def announce() -> None:
    """Register the ids now when gymnasium is loaded, otherwise as soon as it is."""
    loaded = sys.modules.get(_GYMNASIUM)
    if loaded is not None and hasattr(loaded, "registry"):
        register_ids(loaded)
    elif not any(isinstance(finder, _WaitsForGymnasium) for finder in sys.meta_path):
        sys.meta_path.insert(0, _WaitsForGymnasium())


class _WaitsForGymnasium(MetaPathFinder):
    """Stands in the way of one import, that of gymnasium, and adds a step to its end."""

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if fullname != _GYMNASIUM:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(fullname)
        if spec is not None and spec.loader is not None:
            spec.loader = _ThenRegisters(spec.loader)
        return spec


class _ThenRegisters(Loader):
    """Loads a module as its own loader does, then registers the ids with it."""

    def __init__(self, loader: Loader) -> None:
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        self._loader.exec_module(module)
        register_ids(module)
