"""What the page asks of a document and of a stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.builder.contracts import Judgement, OpenedTask, PlannedPath, ReachSpot, TaskText, WaypointVerdict
from rlbench_pin.scene import SceneSpec
from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.recording import Frame, Problem, Recording


class Document(Protocol):
    """A task that is being edited; see `builder.document`."""

    @property
    def name(self) -> str:
        """Name of the task."""
        ...

    @property
    def folder(self) -> Path:
        """Where its files lie."""
        ...

    @property
    def scene_text(self) -> str:
        """What `<task>.toml` says."""
        ...

    @property
    def python_text(self) -> str:
        """What `<task>.py` says."""
        ...

    @property
    def texts(self) -> tuple[str, str]:
        """Both texts alone."""
        ...

    @property
    def saved(self) -> tuple[bytes | None, bytes | None]:
        """What both files say on disk; None for one that is not there."""
        ...

    @property
    def text(self) -> TaskText:
        """Both texts."""
        ...

    @property
    def spec(self) -> SceneSpec | None:
        """The scene, as the last valid text says it."""
        ...

    @property
    def problems(self) -> Sequence[Problem]:
        """What is wrong with the two texts."""
        ...

    @property
    def behaviour(self) -> Any:
        """What forms can edit of the Python."""
        ...

    @property
    def step(self) -> int:
        """A number that grows with every edit."""
        ...

    @property
    def unsaved(self) -> bool:
        """Whether the texts differ from what is on disk."""
        ...

    @property
    def undoable(self) -> str:
        """Name of the edit that `undo` takes back; empty when there is none."""
        ...

    @property
    def redoable(self) -> str:
        """Name of the edit that `redo` makes again; empty when there is none."""
        ...

    def add(self, table: str, values: Mapping[str, Any]) -> str:
        """Add a thing, and return its name."""
        ...

    def set(self, name: str, key: str, value: Any, merge: str = "") -> None:
        """Change a value of a thing; edits with the same `merge` in a row are one."""
        ...

    def set_several(self, name: str, values: Mapping[str, Any], merge: str = "") -> None:
        """Change values of a thing that go together, in one step."""
        ...

    def set_placement(self, key: str, value: Any) -> None:
        """Change a value of `[placement]`; a pose is one in the world."""
        ...

    def duplicate(self, name: str) -> str:
        """Add a thing like another, and return its name."""
        ...

    def delete(self, name: str, with_dependants: bool = False) -> None:
        """Take a thing away."""
        ...

    def insert_waypoint(self, index: int, values: Mapping[str, Any]) -> str:
        """Add a waypoint before another, and return its name."""
        ...

    def move_waypoint(self, name: str, index: int) -> str:
        """Visit a waypoint as the one of that number, and return its name then."""
        ...

    def attach(self, name: str, parent: str, pose: Any, merge: str = "") -> None:
        """Hang a thing on another, at a pose in its frame that is written without rounding what counts."""
        ...

    def rename(self, old: str, new: str) -> Sequence[str]:
        """Call a thing otherwise wherever it is named; lines of Python that name it in a way that was left."""
        ...

    def set_scene_text(self, text: str) -> None:
        """Replace `<task>.toml`."""
        ...

    def set_python_text(self, text: str) -> None:
        """Replace `<task>.py`."""
        ...

    def set_behaviour(self, field: str, value: Any) -> None:
        """Change what a form edits of the Python."""
        ...

    def take(self, name: str, texts: tuple[str, str], merge: str = "") -> None:
        """Put other texts in the place of both, as one edit."""
        ...

    def undo(self) -> str:
        """Take the last edit back."""
        ...

    def redo(self) -> str:
        """Make it again."""
        ...

    def save(self, over: bool = False) -> None:
        """Write both files, with `over` also when somebody else has changed them."""
        ...

    def changed_on_disk(self) -> Sequence[Path]:
        """The files that somebody else has changed."""
        ...

    def reload(self) -> None:
        """Read both files again."""
        ...


class Stage(Protocol):
    """The world in a process of its own; see `builder.worker`. Every call may raise what went wrong there."""

    def open(self, text: TaskText, *, run_task: bool) -> OpenedTask:
        """Build the world of a task; without `run_task` its Python is not run."""
        ...

    def reset(self, seed: int, variation: int = 0) -> Recording:
        """Begin an episode."""
        ...

    def place(self, scene: str) -> OpenedTask:
        """Take a changed scene over; quick where it only puts things elsewhere."""
        ...

    def reach(self) -> Sequence[WaypointVerdict]:
        """Say whether the hand gets to each waypoint."""
        ...

    def follow(self, pose: FloatArray, configuration: FloatArray) -> tuple[FloatArray, float]:
        """Move the tip towards a pose (7,) by differential IK: where the joints end, and how far the tip stays away [m]."""
        ...

    def paths(self, on_path: Callable[[PlannedPath], None] | None = None) -> Sequence[PlannedPath]:
        """Plan the way to each waypoint."""
        ...

    def demonstrate(self, seed: int, variation: int = 0, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Play a demonstration."""
        ...

    def simulate(self, seconds: float, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Let time pass."""
        ...

    def images(self, size: int = 128, frame: Frame | None = None) -> Mapping[str, NDArray[np.uint8]]:
        """Return what the cameras see, now or in a frame of a recording."""
        ...

    def judge(
        self,
        episodes: int,
        on_judgement: Callable[[Judgement], None] | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> Sequence[Judgement]:
        """Ask all that a task has to keep."""
        ...

    def reach_map(self, layouts: int, on_spot: Callable[[ReachSpot], None] | None = None) -> Sequence[ReachSpot]:
        """Look at layouts all over the table."""
        ...

    def cancel(self, operation: str = "") -> bool:
        """End what runs; whether something did."""
        ...

    def close(self) -> None:
        """End its processes."""
        ...
