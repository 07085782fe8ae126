"""Dragging with the gizmo: the scene follows at once, the text a little later, the arm as fast as possible."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from viser import BoxHandle, SceneApi

from rlbench_pin.builder.view.placing import (
    DropTargets,
    body_triangles,
    height_below,
    in_frame,
    is_attached_to,
    on_grid,
    own_points,
    resting_on,
    snap_yaw,
    tidy,
)
from rlbench_pin.builder.view.scene_view import Phase, SceneView
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.world_sync import WorldSync
from rlbench_pin.scene import BodySpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, compose, inverse, pose_to_matrix, rotation_distance
from rlbench_pin.viewer.places import places_at_rest

_YELLOW = (255, 200, 0)


@dataclass(frozen=True, eq=False)
class _Grabbed:
    """The dragged element."""

    name: str
    start: FloatArray
    points: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    """Its vertices (n, 3) in its own frame."""
    others: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    """Triangles (m, 3, 3) of the other bodies in the world."""
    targets: DropTargets | None = None
    """Bodies that it can be dropped onto; None if it keeps its parent."""


class Dragging:
    """Moves the selected element with the gizmo.

    Args:
        session: The edited task.
        view: The scene.
        world: Makes the arm follow a waypoint.
        mark: Outlines the body onto which the element would be dropped.
    """

    def __init__(self, session: Session, view: SceneView, world: WorldSync, mark: DropMark) -> None:
        self._session, self._view, self._world, self._mark = session, view, world, mark
        self._grabbed: _Grabbed | None = None
        self._number = 0

    def drag(self, pose: FloatArray, phase: Phase) -> None:
        """Process a pose (7,) of the gizmo. Calls come in order and have to return fast."""
        session = self._session
        if phase == "start" or self._grabbed is None:
            self._number += 1
            self._grabbed = replace(self._grab(session.selected, pose), targets=self._targets())
        grabbed, number = self._grabbed, self._number
        snapped = self._snapped(grabbed, pose)
        is_over = phase == "end"
        self._view.is_dragging = not is_over
        self._view.move({grabbed.name: snapped})
        if session.table_of(grabbed.name) == "waypoint" and not is_over:
            self._world.follow(snapped, begin=phase == "start")
        target = self._target(grabbed, snapped)
        if target and is_over:
            session.post(lambda: self._drop(grabbed.name, target, snapped, number))
        elif phase == "update" or (is_over and not np.allclose(snapped, grabbed.start)):
            if grabbed.name != ROOT or is_over:
                session.post(lambda: self._commit(grabbed.name, snapped, number), "" if is_over else "drag")
        elif is_over:
            session.post(session.changed)
        if is_over:
            self._grabbed = None
            self._mark.show("")

    def _targets(self) -> DropTargets | None:
        spec, name = self._session.spec, self._session.selected
        wanted = self._session.drops_onto and name != ROOT
        return DropTargets(spec, places_at_rest(spec).links, name) if wanted else None

    def _target(self, grabbed: _Grabbed, pose: FloatArray) -> str:
        """Return the body onto which the element would be dropped, and outline it; empty if there is none."""
        if grabbed.targets is None or np.allclose(pose, grabbed.start):
            return ""
        name, element = grabbed.targets.below(pose[:3]), self._session.element(grabbed.name)
        self._mark.show(name, grabbed.targets.box(name) if name else None)
        return name if element is not None and element.parent != name else ""

    def _drop(self, name: str, parent: str, pose: FloatArray, number: int) -> None:
        """Attach an element to a body at a world pose (7,); one undo step with the drag."""
        frame = self._session.places.of(parent)
        if frame is not None:
            local = compose(inverse(frame), pose)
            self._session.do(lambda document: document.attach(name, parent, local, merge=f"drag {number}"))

    def snap_now(self) -> None:
        """Snap the selected element, in the thread of edits."""
        name = self._session.selected
        pose = self._session.places.of(name)
        if pose is not None:
            self._number += 1
            self._commit(name, self._snapped(self._grab(name, pose), pose), self._number)

    def _grab(self, name: str, pose: FloatArray) -> _Grabbed:
        spec, snap = self._session.spec, self._session.snap
        element = self._session.element(name)
        if snap not in ("table", "surface below") or not isinstance(element, BodySpec):
            return _Grabbed(name, pose)
        points = own_points(spec, element)
        if snap == "table":
            return _Grabbed(name, pose, points)
        links = places_at_rest(spec).links
        others = [body_triangles(spec, body, links) for body in spec.body if not is_attached_to(spec, body, name)]
        return _Grabbed(name, pose, points, np.concatenate([np.zeros((0, 3, 3)), *others]))

    def _snapped(self, grabbed: _Grabbed, pose: FloatArray) -> FloatArray:
        snap = self._session.snap
        if snap == "free":
            return tidy(pose)
        turned = rotation_distance(pose, grabbed.start) > 1e-4
        near = snap_yaw(pose) if turned else pose
        if snap == "grid":
            moved = np.abs(pose[:3] - grabbed.start[:3]) > 1e-6  # coordinates that are not dragged stay off the grid
            near = np.concatenate([np.where(moved, on_grid(near)[:3], near[:3]), near[3:]])
        elif snap == "table":
            near = resting_on(near, grabbed.points, TABLE_HEIGHT)
        else:
            matrix = pose_to_matrix(near)
            points = grabbed.points @ matrix[:3, :3].T + matrix[:3, 3]
            near = resting_on(near, grabbed.points, height_below(points, grabbed.others))
        return near

    def _commit(self, name: str, pose: FloatArray, number: int) -> None:
        """Write a world pose (7,) into the scene; a drag is one undo step."""
        session, element = self._session, self._session.element(name)
        if name == ROOT:
            session.do(lambda document: document.set_placement("pose", tuple(tidy(pose).tolist())))
        elif element is not None and (frame := session.places.of(element.parent)) is not None:
            local = tuple(in_frame(pose, frame).tolist())
            if np.allclose(local, element.pose, atol=1e-9):
                session.changed()
                return
            session.do(lambda document: document.set(name, "pose", local, merge=f"drag {number}"))


class DropMark:
    """Outlines the body onto which an element would be dropped."""

    def __init__(self, scene: SceneApi) -> None:
        self._scene = scene
        self._shown = ""
        self._node: BoxHandle | None = None

    @property
    def shown(self) -> str:
        """Name of the outlined body; empty if there is none."""
        return self._shown

    def show(self, name: str, box: FloatArray | None = None) -> None:
        """Outline a body by the lowest and highest corner (2, 3) of its box; an empty name removes the outline."""
        if name == self._shown:
            return
        if self._node is not None:
            self._node.remove()
            self._node = None
        self._shown = name
        if box is not None:
            size, middle = box[1] - box[0] + 0.01, 0.5 * (box[0] + box[1])
            self._node = self._scene.add_box("/drop", _YELLOW, tuple(size), wireframe=True, cast_shadow=False, position=middle)
