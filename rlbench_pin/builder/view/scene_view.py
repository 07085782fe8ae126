"""The scene in 3D: bodies, volumes and frames, grippers at waypoints, planned paths, the reach map, the gizmo."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, TypeAlias

import numpy as np
from viser import (
    BoxHandle,
    CylinderHandle,
    FrameHandle,
    IcosphereHandle,
    LineSegmentsHandle,
    SceneApi,
    TransformControlsEvent,
    TransformControlsHandle,
)

from rlbench_pin.builder.contracts import PlannedPath, ReachSpot, WaypointVerdict
from rlbench_pin.robot import DEFAULT_ROBOT, RobotModel, robot_description
from rlbench_pin.scene import BodySpec, FrameSpec, RegionSpec, SceneSpec, SensorSpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, compose
from rlbench_pin.viewer.figures import Figures, move_node
from rlbench_pin.viewer.places import Places, places_at_rest
from rlbench_pin.viewer.player import NEAREST
from rlbench_pin.viewer.recording import Frame

Phase = Literal["start", "update", "end"]
OnDrag = Callable[[FloatArray, Phase], None]
"""Receives the pose (7,) of the gizmo and the phase of the drag."""
GRIPPERS = ("all", "selected", "none")
"""The waypoints at which a gripper is shown."""
GREEN, AMBER, RED, WHITE, GRAY = (60, 180, 75), (255, 170, 0), (220, 50, 47), (170, 180, 190), (120, 120, 120)
_VERDICT_COLORS = {"free": GREEN, "collides": AMBER, "unreachable": RED}
_PATH, _REGION, _SENSOR, _SELECTED = (30, 90, 200), (50, 110, 220), (150, 70, 200), (255, 200, 0)
_GIZMO_SIZE, _MIN_THICKNESS, _REACH_HEIGHT = 0.14, 0.002, 0.003  # [m]
_EMPTY = SceneSpec(format=2)
_Unseen: TypeAlias = FrameSpec | RegionSpec | SensorSpec
_Node: TypeAlias = FrameHandle | BoxHandle | CylinderHandle | IcosphereHandle


class SceneView:
    """Draws a scene file. Its methods may be called from any thread.

    Args:
        scene: The 3D scene of the page.
        on_pick: Receives the name of the body, region, waypoint, ... that the user clicks.
        on_drag: Called while the gizmo is dragged.
    """

    def __init__(self, scene: SceneApi, on_pick: Callable[[str], None], on_drag: OnDrag) -> None:
        self._lock = threading.RLock()
        self._scene = scene
        self.figures = Figures(scene, on_pick=lambda name: on_pick(name.partition("/")[0]))
        self._volumes, self._gizmo = Volumes(scene, on_pick), _gizmo(scene, on_drag)
        self._curve_handles: list[FrameHandle | LineSegmentsHandle] = []
        self._spec, self._places, self._selected = SceneSpec(format=2), Places({}, {}), ROOT
        self._verdicts: Mapping[str, WaypointVerdict] = {}
        self._paths: tuple[PlannedPath, ...] = ()
        self._ghosts: set[str] = set()
        self._model = RobotModel(robot_description(DEFAULT_ROBOT))
        self._q: FloatArray = self._model.home
        self._follows, self._is_playing = "", False
        self.grippers, self.is_dragging, self.shadows = "all", False, False
        self.figures.shadows(False)
        self.faults: Mapping[str, str] = {}

    def show(self, spec: SceneSpec) -> None:
        """Draw a scene at rest; the arm stays where it has followed a dragged waypoint."""
        with self._lock:
            self._spec, self._places, self._is_playing = spec, places_at_rest(spec), False
            self.faults = self.figures.show(spec)
            self.figures.mark(())
            self.figures.remove_ghost(NEAREST)
            if self._follows == "":
                self._show_arm(self._model.home)

    def show_added(self, added: Sequence[BodySpec]) -> None:
        """Draw also the bodies that an episode adds, until the scene is shown again."""
        with self._lock:
            self.figures.show(self._spec.model_copy(update={"body": (*self._spec.body, *added)}))

    def point_out(self, selected: str, verdicts: Mapping[str, WaypointVerdict], paths: tuple[PlannedPath, ...]) -> None:
        """Show the selection, the reachability of the waypoints and the planned paths."""
        with self._lock:
            self._selected, self._verdicts = selected, verdicts
            if self._follows not in ("", selected):
                self._follows = ""
                self._show_arm(self._model.home)
            self._volumes.show(_EMPTY if self._is_playing else self._spec, self._places, selected)
            self._show_grippers()
            self._show_curve()
            self._show_paths(paths)
            if not self.is_dragging:
                self._show_gizmo(None if self._is_playing else self._places.of(selected))

    def move(self, given: Mapping[str, FloatArray]) -> None:
        """Show dragged elements at world poses (7,), with all that is attached to them; the gizmo stays."""
        with self._lock:
            self._places = places_at_rest(self._spec, given)
            self.figures.move(self._places.links)
            self._volumes.move(self._places)
            self._show_grippers()
            self._show_curve()

    def cast_shadows(self, cast: bool) -> None:
        """Switch shadows; without a graphics card they make a frame half as slow again."""
        self.shadows = cast
        self.figures.shadows(cast)

    def tip(self) -> FloatArray:
        """Return the pose (7,) of the tip of the shown arm."""
        with self._lock:
            return self._model.tip_pose(self._q)

    def played(self, frame: Frame) -> None:
        """Record that a frame of a recording is shown; hide what is drawn at rest only."""
        with self._lock:
            self._q, self._follows = np.array(frame.arm), ""
            if not self._is_playing:
                self._is_playing = True
                self._volumes.show(_EMPTY, self._places, "")
                self._show_grippers()
                self._show_curve()
                self._show_gizmo(None)

    def follow(self, q: FloatArray) -> None:
        """Show the arm at joint positions (n,) [rad] at which it has followed the selected waypoint."""
        with self._lock:
            self._follows = self._selected
            self._show_arm(q)

    def show_reach(self, spots: Sequence[ReachSpot]) -> None:
        """Draw the reach map: a point on the table for each layout. Without layouts, remove it."""
        if not spots:
            self._scene.remove_by_name("/reach")
            return
        points = np.array([[spot.place[0], spot.place[1], TABLE_HEIGHT + _REACH_HEIGHT] for spot in spots])
        colors = np.array([GRAY if not spot.free else GREEN if all(spot.reached) else RED for spot in spots], dtype=np.uint8)
        self._scene.add_point_cloud("/reach", points, colors, point_size=0.015, point_shape="circle")

    def _show_arm(self, q: FloatArray) -> None:
        robot, self._q = robot_description(DEFAULT_ROBOT), q
        self.figures.arm(q, [robot.gripper_open] * len(robot.gripper_joints))

    def _show_gizmo(self, pose: FloatArray | None) -> None:
        self._gizmo.visible = pose is not None
        if pose is not None:
            move_node(self._gizmo, pose)

    def _show_grippers(self) -> None:
        shown = {
            w.name
            for w in self._spec.waypoint
            if self.grippers == "all" or (self.grippers == "selected" and w.name == self._selected)
        }
        for name in self._ghosts - (set() if self._is_playing else shown):
            self.figures.remove_ghost(name)  # the ghost of a failure stays
            self._ghosts.discard(name)
        for waypoint in self._spec.waypoint:
            pose, verdict = self._places.of(waypoint.name), self._verdicts.get(waypoint.name)
            if waypoint.name in shown and pose is not None and not self._is_playing:
                self.figures.ghost(waypoint.name, pose, WHITE if verdict is None else _VERDICT_COLORS[verdict.standing])
                self._ghosts.add(waypoint.name)

    def _show_curve(self) -> None:
        """Draw the poses of the curve to the selected waypoint, with lines between them."""
        for handle in self._curve_handles:
            handle.remove()
        self._curve_handles.clear()
        waypoint = next((w for w in self._spec.waypoint if w.name == self._selected), None)
        pose = self._places.of(self._selected)
        if self._is_playing or waypoint is None or pose is None:
            return
        poses = [compose(pose, np.array(point)) for point in waypoint.points]
        for number, curve_pose in enumerate(poses):
            handle = self._scene.add_frame(f"/curve/{number}", axes_length=0.025, axes_radius=0.0015, origin_color=_SELECTED)
            move_node(handle, curve_pose)
            self._curve_handles.append(handle)
        if len(poses) > 1:
            points = np.array([p[:3] for p in poses])
            self._curve_handles.append(
                self._scene.add_line_segments("/curve/lines", _segments(points), _SELECTED, thickness=0.003)
            )

    def _show_paths(self, paths: tuple[PlannedPath, ...]) -> None:
        if paths is self._paths:
            return
        for path in self._paths:
            self._scene.remove_by_name(f"/paths/{path.waypoint}")
        self._paths = paths
        for path in paths:
            if len(path.points) > 1:
                self._scene.add_line_segments(f"/paths/{path.waypoint}", _segments(path.points), _PATH, thickness=0.004)


def _segments(points: FloatArray) -> np.ndarray:
    """Return the segments (n - 1, 2, 3) between points (n, 3)."""
    points = np.asarray(points, dtype=np.float32)
    return np.stack([points[:-1], points[1:]], axis=1)


def _gizmo(scene: SceneApi, on_drag: OnDrag) -> TransformControlsHandle:
    """Return a hidden gizmo."""
    handle = scene.add_transform_controls("/gizmo", _GIZMO_SIZE, depth_test=False, visible=False)

    async def heard(event: TransformControlsEvent) -> None:  # in the event loop, which keeps the order of poses
        w, x, y, z = handle.wxyz
        on_drag(np.array([*handle.position, x, y, z, w], dtype=float), event.phase)

    handle.on_update(heard)
    return handle


class Volumes:
    """Draws frames as axes, regions and sensors as translucent volumes.

    Args:
        scene: The 3D scene of the page.
        on_pick: Receives the name of a clicked volume.
    """

    def __init__(self, scene: SceneApi, on_pick: Callable[[str], None]) -> None:
        self._scene, self._on_pick = scene, on_pick
        self._nodes: dict[str, tuple[tuple[object, ...], _Node]] = {}

    def show(self, spec: SceneSpec, places: Places, selected: str) -> None:
        """Draw those of a scene; unchanged ones stay."""
        elements: list[_Unseen] = [*spec.frame, *spec.region, *spec.sensor]
        wanted = {element.name: _appearance(element, element.name == selected) for element in elements}
        for name in [name for name, (drawn, _) in self._nodes.items() if wanted.get(name) != drawn]:
            self._nodes.pop(name)[1].remove()
        for element in elements:
            if element.name not in self._nodes:
                self._nodes[element.name] = (wanted[element.name], self._draw(element, element.name == selected))
        self.move(places)

    def move(self, places: Places) -> None:
        """Put them at their world poses."""
        for name, (_, node) in self._nodes.items():
            if (pose := places.of(name)) is not None:
                move_node(node, pose)

    def _draw(self, element: _Unseen, is_selected: bool) -> _Node:
        path = f"/shapes/{element.name}"
        if isinstance(element, FrameSpec):
            return self._scene.add_frame(path, axes_length=0.04, axes_radius=0.002, origin_radius=0.004)
        color = _SELECTED if is_selected else _REGION if isinstance(element, RegionSpec) else _SENSOR
        size, diameter = element.size, element.size[0]
        node: BoxHandle | CylinderHandle | IcosphereHandle
        if isinstance(element, SensorSpec) and element.shape == "sphere":
            node = self._scene.add_icosphere(path, 0.5 * diameter, color, opacity=0.3, cast_shadow=False)
        elif isinstance(element, SensorSpec) and element.shape == "cylinder":
            node = self._scene.add_cylinder(path, 0.5 * diameter, size[1], color, opacity=0.3, cast_shadow=False)
        else:
            edges = (size[0], size[1], max(_MIN_THICKNESS, size[2])) if len(size) == 3 else (diameter,) * 3
            node = self._scene.add_box(path, color, edges, opacity=0.3, cast_shadow=False)
        node.on_click(lambda _: self._on_pick(element.name))  # type: ignore[union-attr]
        return node


def _appearance(element: _Unseen, is_selected: bool) -> tuple[object, ...]:
    """Return all that the drawing depends on, except the pose."""
    if isinstance(element, FrameSpec):
        return (type(element),)
    return (type(element), element.shape if isinstance(element, SensorSpec) else "box", element.size, is_selected)
