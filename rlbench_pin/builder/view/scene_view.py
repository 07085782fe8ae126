"""The scene in 3D: bodies, what simulation does not show, hands at waypoints, the gizmo of what is selected."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from viser import SceneApi

from rlbench_pin.builder.contracts import PlannedPath, WaypointVerdict
from rlbench_pin.builder.view.gizmo import Gizmo, OnDrag
from rlbench_pin.builder.view.shapes import CurvePoses, Shapes
from rlbench_pin.robot import DEFAULT_ROBOT, RobotModel, robot_description
from rlbench_pin.scene import BodySpec, SceneSpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.figures import Figures
from rlbench_pin.viewer.places import Places, places_at_rest
from rlbench_pin.viewer.player import NEAREST
from rlbench_pin.viewer.recording import Frame

PATH = (30, 90, 200)
GREEN, AMBER, RED, WHITE = (60, 180, 75), (255, 170, 0), (220, 50, 47), (170, 180, 190)
_NOTHING = SceneSpec(format=2)
_COLORS = {"free": GREEN, "collides": AMBER, "unreachable": RED}
HANDS = ("all", "selected", "none")
"""At which waypoints the hand is shown."""


class SceneView:
    """Draws what a scene file says. Its methods may be called from any thread.

    Args:
        scene: Where to draw.
        on_pick: Called with the name of the body, region, waypoint, ... on which somebody clicked.
        on_drag: Called while the gizmo is dragged.
    """

    def __init__(self, scene: SceneApi, on_pick: Callable[[str], None], on_drag: OnDrag) -> None:
        self._lock = threading.RLock()
        self._scene = scene
        self.figures = Figures(scene, on_pick=lambda name: on_pick(name.partition("/")[0]))
        self._shapes, self._gizmo = Shapes(scene, on_pick), Gizmo(scene, on_drag)
        self._curve = CurvePoses(scene)
        self._spec, self._places, self._selected = SceneSpec(format=2), Places({}, {}), ROOT
        self._verdicts: Mapping[str, WaypointVerdict] = {}
        self._curves: tuple[PlannedPath, ...] = ()
        self._ghosts: set[str] = set()
        self._model = RobotModel(robot_description(DEFAULT_ROBOT))
        self._q: FloatArray = self._model.home
        self._follows, self._is_playing = "", False
        self.hands, self.is_dragging, self.shadows = "all", False, False
        self.figures.shadows(False)
        self.faults: Mapping[str, str] = {}

    def show(self, spec: SceneSpec) -> None:
        """Draw a scene at rest; the arm stays where a dragged hand has taken it."""
        with self._lock:
            self._spec, self._places, self._is_playing = spec, places_at_rest(spec), False
            self.faults = self.figures.show(spec)
            self.figures.mark(())
            self.figures.remove_ghost(NEAREST)
            if self._follows == "":
                self._put_arm(self._model.home)

    def show_added(self, added: Sequence[BodySpec]) -> None:
        """Draw also what an episode adds to the scene, until the scene is shown again."""
        with self._lock:
            self.figures.show(self._spec.model_copy(update={"body": (*self._spec.body, *added)}))

    def point_out(self, selected: str, verdicts: Mapping[str, WaypointVerdict], paths: tuple[PlannedPath, ...]) -> None:
        """Show what is selected, and what the stage says of the waypoints."""
        with self._lock:
            self._selected, self._verdicts = selected, verdicts
            if self._follows not in ("", selected):
                self._follows = ""
                self._put_arm(self._model.home)
            self._shapes.show(_NOTHING if self._is_playing else self._spec, self._places, selected)
            self._show_hands()
            self._show_curve()
            self._show_paths(paths)
            if not self.is_dragging:
                self._gizmo.show(None if self._is_playing else self._places.of(selected))

    def move(self, given: Mapping[str, FloatArray]) -> None:
        """Show things at world poses (7,) that they are just being given, with what hangs on them; the gizmo stays."""
        with self._lock:
            self._places = places_at_rest(self._spec, given)
            self.figures.move(self._places.links)
            self._shapes.move(self._places)
            self._show_hands()
            self._show_curve()

    def cast_shadows(self, cast: bool) -> None:
        """Draw shadows or not; without a graphics card a picture takes half as long again with them."""
        self.shadows = cast
        self.figures.shadows(cast)

    def tip(self) -> FloatArray:
        """Return the pose (7,) of the tip of the arm that is shown."""
        with self._lock:
            return self._model.tip_pose(self._q)

    def played(self, frame: Frame) -> None:
        """Take note that an instant of a recording is shown: shapes and hands stand elsewhere then, and would hide it."""
        with self._lock:
            self._q, self._follows = np.array(frame.arm), ""
            if not self._is_playing:
                self._is_playing = True
                self._shapes.show(_NOTHING, self._places, "")
                self._show_hands()
                self._show_curve()
                self._gizmo.show(None)

    def follow(self, q: FloatArray) -> None:
        """Show the arm at joint positions (n,) [rad] to which it has followed the selected hand."""
        with self._lock:
            self._follows = self._selected
            self._put_arm(q)

    def _put_arm(self, q: FloatArray) -> None:
        robot, self._q = robot_description(DEFAULT_ROBOT), q
        self.figures.arm(q, [robot.gripper_open] * len(robot.gripper_joints))

    def _show_hands(self) -> None:
        shown = {
            w.name for w in self._spec.waypoint if self.hands == "all" or (self.hands == "selected" and w.name == self._selected)
        }
        for name in self._ghosts - (set() if self._is_playing else shown):
            self.figures.remove_ghost(name)  # those of a failure are not ours
            self._ghosts.discard(name)
        for waypoint in self._spec.waypoint:
            pose, verdict = self._places.of(waypoint.name), self._verdicts.get(waypoint.name)
            if waypoint.name in shown and pose is not None and not self._is_playing:
                color = WHITE if verdict is None else _COLORS[verdict.standing]
                self.figures.ghost(waypoint.name, pose, color)
                self._ghosts.add(waypoint.name)

    def _show_curve(self) -> None:
        chosen = None if self._is_playing else next((w for w in self._spec.waypoint if w.name == self._selected), None)
        self._curve.show(chosen, self._places.of(self._selected))

    def _show_paths(self, paths: tuple[PlannedPath, ...]) -> None:
        if paths is self._curves:
            return
        for path in self._curves:
            self._scene.remove_by_name(f"/paths/{path.waypoint}")
        self._curves = paths
        for path in paths:
            if len(path.points) > 1:
                points = np.asarray(path.points, dtype=np.float32)
                segments = np.stack([points[:-1], points[1:]], axis=1)
                self._scene.add_line_segments(f"/paths/{path.waypoint}", segments, PATH, thickness=0.004)
