"""What simulation does not show: regions, sensors and frames, as translucent shapes and small axes; poses of curves."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from viser import BoxHandle, CylinderHandle, FrameHandle, IcosphereHandle, LineSegmentsHandle, SceneApi

from rlbench_pin.scene import FrameSpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.viewer.places import Places

REGION, SENSOR, CHOSEN = (50, 110, 220), (150, 70, 200), (255, 200, 0)
_THIN = 0.002
_Drawn = tuple[object, ...]


_Unseen = FrameSpec | RegionSpec | SensorSpec
_Node: TypeAlias = FrameHandle | BoxHandle | CylinderHandle | IcosphereHandle


class Shapes:
    """Draws frames, regions and sensors.

    Args:
        scene: Where to draw.
        on_pick: Called with the name of what somebody clicked on.
    """

    def __init__(self, scene: SceneApi, on_pick: Callable[[str], None]) -> None:
        self._scene, self._on_pick = scene, on_pick
        self._nodes: dict[str, tuple[_Drawn, _Node]] = {}

    def show(self, spec: SceneSpec, places: Places, selected: str) -> None:
        """Draw those of a scene; what is drawn already stays."""
        things: list[_Unseen] = [*spec.frame, *spec.region, *spec.sensor]
        wanted = {thing.name: _drawn(thing, thing.name == selected) for thing in things}
        for name in [name for name, (drawn, _) in self._nodes.items() if wanted.get(name) != drawn]:
            self._nodes.pop(name)[1].remove()
        for thing in things:
            if thing.name not in self._nodes:
                self._nodes[thing.name] = (wanted[thing.name], self._draw(thing, thing.name == selected))
        self.move(places)

    def move(self, places: Places) -> None:
        """Put them where they stand."""
        for name, (_, node) in self._nodes.items():
            if (pose := places.of(name)) is not None:
                _put(node, pose)

    def _draw(self, thing: _Unseen, chosen: bool) -> _Node:
        path = f"/shapes/{thing.name}"
        if isinstance(thing, FrameSpec):
            return self._scene.add_frame(path, axes_length=0.04, axes_radius=0.002, origin_radius=0.004)
        rgb = CHOSEN if chosen else REGION if isinstance(thing, RegionSpec) else SENSOR
        box, round_size = thing.size, thing.size[0]
        node: BoxHandle | CylinderHandle | IcosphereHandle
        if isinstance(thing, SensorSpec) and thing.shape == "sphere":
            node = self._scene.add_icosphere(path, 0.5 * round_size, rgb, opacity=0.3, cast_shadow=False)
        elif isinstance(thing, SensorSpec) and thing.shape == "cylinder":
            node = self._scene.add_cylinder(path, 0.5 * round_size, thing.size[1], rgb, opacity=0.3, cast_shadow=False)
        else:
            edges = (box[0], box[1], max(_THIN, box[2])) if len(box) == 3 else (round_size,) * 3
            node = self._scene.add_box(path, rgb, edges, opacity=0.3, cast_shadow=False)
        node.on_click(lambda _: self._on_pick(thing.name))  # type: ignore[union-attr]
        return node


class CurvePoses:
    """Draws the poses that the curve to a waypoint passes, with lines between them.

    Args:
        scene: Where to draw.
    """

    def __init__(self, scene: SceneApi) -> None:
        self._scene = scene
        self._shown: list[FrameHandle | LineSegmentsHandle] = []

    def show(self, waypoint: WaypointSpec | None, pose: FloatArray | None) -> None:
        """Draw those of a waypoint at a world pose (7,); None, and one without a curve of poses, has none."""
        for handle in self._shown:
            handle.remove()
        self._shown.clear()
        if waypoint is None or pose is None:
            return
        poses = [compose(pose, np.array(point)) for point in waypoint.points]
        for number, (x, y, z, *turn) in enumerate(poses):
            wxyz = (turn[3], *turn[:3])
            frame = self._scene.add_frame(
                f"/curve/{number}", axes_length=0.025, axes_radius=0.0015, origin_color=CHOSEN, position=(x, y, z), wxyz=wxyz
            )
            self._shown.append(frame)
        if len(poses) > 1:
            points = np.array([p[:3] for p in poses], dtype=np.float32)
            segments = np.stack([points[:-1], points[1:]], axis=1)
            self._shown.append(self._scene.add_line_segments("/curve/lines", segments, CHOSEN, thickness=0.003))


def _drawn(thing: _Unseen, chosen: bool) -> _Drawn:
    """Return all that a picture depends on, but the place."""
    if isinstance(thing, FrameSpec):
        return (type(thing),)
    return (type(thing), thing.shape if isinstance(thing, SensorSpec) else "box", thing.size, chosen)


def _put(node: _Node, pose: FloatArray) -> None:
    node.position = np.array(pose[:3])
    node.wxyz = np.array([pose[6], pose[3], pose[4], pose[5]])
