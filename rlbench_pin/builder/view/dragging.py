"""What happens while the gizmo is dragged: the picture follows at once, the text a little later, the arm as fast as it can."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from rlbench_pin.builder.view.dropping import DropMark, Targets, hangs_on
from rlbench_pin.builder.view.gizmo import Phase
from rlbench_pin.builder.view.posing import in_frame, tidy
from rlbench_pin.builder.view.scene_view import SceneView
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.snapping import body_triangles, height_below, on_grid, resting_on, whole_turn
from rlbench_pin.builder.view.watch import Watch
from rlbench_pin.scene import BodySpec, SceneSpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import IDENTITY, TABLE_HEIGHT, FloatArray, compose, inverse, pose_to_matrix, rotation_distance
from rlbench_pin.viewer.places import places_at_rest

_EMPTY = np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class _Grabbed:
    """What is being dragged."""

    name: str
    start: FloatArray
    points: FloatArray = field(default_factory=lambda: _EMPTY)
    """Its corners (n, 3) in its own frame."""
    others: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    """Triangles (m, 3, 3) of the other bodies in the world."""
    targets: Targets | None = None
    """What it can be dropped onto; None where that is not wanted."""


class Dragging:
    """Moves what is selected with the gizmo.

    Args:
        session: What is being edited.
        view: Where it is shown.
        watch: Has the arm follow a waypoint.
        mark: Shows onto what it would be dropped.
    """

    def __init__(self, session: Session, view: SceneView, watch: Watch, mark: DropMark) -> None:
        self._session, self._view, self._watch, self._mark = session, view, watch, mark
        self._grabbed: _Grabbed | None = None
        self._number = 0

    def drag(self, pose: FloatArray, phase: Phase) -> None:
        """Take a pose (7,) of the gizmo; called in the order of the drag, and quick."""
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
            self._watch.follow(snapped, begin=phase == "start")
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

    def _targets(self) -> Targets | None:
        spec, name = self._session.spec, self._session.selected
        wanted = self._session.drops_onto and name != ROOT
        return Targets(spec, places_at_rest(spec).links, name) if wanted else None

    def _target(self, grabbed: _Grabbed, pose: FloatArray) -> str:
        """Return the body onto which a dragged thing would be dropped, and mark it; empty where there is none."""
        if grabbed.targets is None or np.allclose(pose, grabbed.start):
            return ""
        name, thing = grabbed.targets.below(pose[:3]), self._session.thing(grabbed.name)
        self._mark.show(name, grabbed.targets.box(name) if name else None)
        return name if thing is not None and thing.parent != name else ""

    def _drop(self, name: str, parent: str, pose: FloatArray, number: int) -> None:
        """Hang a thing on a body, at a world pose (7,); one step with the drag."""
        frame = self._session.places.of(parent)
        if frame is not None:
            local = compose(inverse(frame), pose)
            self._session.do(lambda document: document.attach(name, parent, local, merge=f"drag {number}"))

    def snap_now(self) -> None:
        """Put what is selected where it would fall; in the thread of edits."""
        name = self._session.selected
        pose = self._session.places.of(name)
        if pose is not None:
            self._number += 1
            self._commit(name, self._snapped(self._grab(name, pose), pose), self._number)

    def _grab(self, name: str, pose: FloatArray) -> _Grabbed:
        spec, snap = self._session.spec, self._session.snap
        thing = self._session.thing(name)
        if snap not in ("table", "surface below") or not isinstance(thing, BodySpec):
            return _Grabbed(name, pose)
        points = own_points(spec, thing)
        if snap == "table":
            return _Grabbed(name, pose, points)
        links = places_at_rest(spec).links
        others = [body_triangles(spec, body, links) for body in spec.body if not hangs_on(spec, body, name)]
        return _Grabbed(name, pose, points, np.concatenate([np.zeros((0, 3, 3)), *others]))

    def _snapped(self, grabbed: _Grabbed, pose: FloatArray) -> FloatArray:
        snap = self._session.snap
        if snap == "free":
            return tidy(pose)
        turned = rotation_distance(pose, grabbed.start) > 1e-4
        near = whole_turn(pose) if turned else pose
        if snap == "grid":
            moved = np.abs(pose[:3] - grabbed.start[:3]) > 1e-6  # what is not moved stays where it is, also off the grid
            near = np.concatenate([np.where(moved, on_grid(near)[:3], near[:3]), near[3:]])
        elif snap == "table":
            near = resting_on(near, grabbed.points, TABLE_HEIGHT)
        else:
            matrix = pose_to_matrix(near)
            points = grabbed.points @ matrix[:3, :3].T + matrix[:3, 3]
            near = resting_on(near, grabbed.points, height_below(points, grabbed.others))
        return near

    def _commit(self, name: str, pose: FloatArray, number: int) -> None:
        """Write a world pose (7,) into the scene; all of one drag are one step."""
        session, thing = self._session, self._session.thing(name)
        if name == ROOT:
            session.do(lambda document: document.set_placement("pose", tuple(tidy(pose).tolist())))
        elif thing is not None and (frame := session.places.of(thing.parent)) is not None:
            local = tuple(in_frame(pose, frame).tolist())
            if np.allclose(local, thing.pose, atol=1e-9):
                session.changed()
                return
            session.do(lambda document: document.set(name, "pose", local, merge=f"drag {number}"))


def own_points(spec: SceneSpec, body: BodySpec) -> FloatArray:
    """Return the corners (n, 3) of what collides of a body, in its own frame."""
    alone = SceneSpec(format=2, body=(body.model_copy(update={"parent": ROOT}),), joint=_joints(spec, body), file=spec.file)
    links = places_at_rest(alone, {body.name: IDENTITY.copy()}).links
    return body_triangles(alone, body, links).reshape(-1, 3)


def _joints(spec: SceneSpec, body: BodySpec) -> tuple:
    return tuple(joint for joint in spec.joint if joint.name.startswith(f"{body.name}/"))
