"""A worker without a world: it keeps what it is asked, and answers at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.builder.contracts import OpenedTask, PlannedPath, ReachSpot, TaskText, ValidationLine, WaypointVerdict
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.recording import Frame, Recording


@dataclass
class WorkerStandIn(WorkerClient):
    """Returns prepared answers; `asked` has the names of the requests."""

    waypoints: tuple[str, ...] = ()
    standing: str = "free"
    asked: list[str] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    fault: str = ""
    recording: Recording = field(default_factory=lambda: Recording((), ()))
    lines: tuple[ValidationLine, ...] = ()
    conditions: tuple[str, ...] = ("a condition",)

    def _ask(self, name: str) -> None:
        self.asked.append(name)
        if self.fault:
            raise RlbenchPinError(self.fault)

    def open(self, text: TaskText, *, run_task: bool) -> OpenedTask:
        """Take a task."""
        self._ask(f"open {run_task}")
        self.texts.append(text.scene)
        return OpenedTask(2, self.conditions, (), self.waypoints)

    def reset(self, seed: int, variation: int = 0) -> Recording:
        """Return the recording."""
        self._ask(f"reset {seed} {variation}")
        return self.recording

    def place(self, scene: str) -> OpenedTask:
        """Take a scene."""
        self._ask("place")
        self.texts.append(scene)
        return OpenedTask(2, self.conditions, (), self.waypoints)

    def reach(self) -> Sequence[WaypointVerdict]:
        """Return the same verdict on all."""
        self._ask("reach")
        q = np.zeros(7)
        return [WaypointVerdict(name, self.standing, "so it is", configuration=q) for name in self.waypoints]  # type: ignore[arg-type]

    def follow(self, pose: FloatArray, configuration: FloatArray) -> tuple[FloatArray, float]:
        """Move the first joint a little."""
        self._ask("follow")
        return configuration + np.eye(7)[0] * 0.1, 0.0

    def paths(self, on_path: Callable[[PlannedPath], None] | None = None) -> Sequence[PlannedPath]:
        """Return a line for each waypoint."""
        self._ask("paths")
        return [PlannedPath(name, np.array([[0.2, 0.0, 1.0], [0.3, 0.0, 1.0]])) for name in self.waypoints]

    def demonstrate(self, seed: int, variation: int = 0, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Return the recording."""
        self._ask(f"demonstrate {seed} {variation}")
        return self.recording

    def simulate(self, seconds: float, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Return the recording."""
        self._ask(f"simulate {seconds}")
        return self.recording

    def images(self, size: int = 128, frame: Frame | None = None) -> dict[str, NDArray[np.uint8]]:
        """Return a black image."""
        self._ask("images")
        return {"front": np.zeros((size, size, 3), np.uint8)}

    def validate(
        self,
        episodes: int,
        on_line: Callable[[ValidationLine], None] | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> Sequence[ValidationLine]:
        """Return the lines."""
        self._ask(f"validate {episodes}")
        return self.lines

    def reach_map(self, layouts: int, on_spot: Callable[[ReachSpot], None] | None = None) -> Sequence[ReachSpot]:
        """Return one layout."""
        self._ask("reach_map")
        spot = ReachSpot((0.2, 0.1, 0.0), (True,), ((0.2, 0.1),), True)
        if on_spot is not None:
            on_spot(spot)
        return [spot]

    def cancel(self, operation: str = "") -> bool:
        """Nothing runs."""
        self.asked.append("cancel")
        return False

    def close(self) -> None:
        """Nothing is to be ended."""
