"""What happens while the gizmo is dragged: the picture follows at once, the text a little later, the arm as fast as it can."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.builder.figures import places_at_rest
from rlbench_pin.builder.view.gizmo import Phase
from rlbench_pin.builder.view.posing import in_frame, tidy
from rlbench_pin.builder.view.scene_view import SceneView
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.snapping import body_triangles, height_below, on_grid, resting_on, whole_turn
from rlbench_pin.builder.view.watch import Watch
from rlbench_pin.scene import BodySpec, SceneSpec
from rlbench_pin.scene.spec import ROOT, PosedSpec
from rlbench_pin.spatial import IDENTITY, TABLE_HEIGHT, FloatArray, pose_to_matrix, rotation_distance

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


class Dragging:
    """Moves what is selected with the gizmo.

    Args:
        session: What is being edited.
        view: Where it is shown.
        watch: Has the arm follow a waypoint.
    """

    def __init__(self, session: Session, view: SceneView, watch: Watch) -> None:
        self._session, self._view, self._watch = session, view, watch
        self._grabbed: _Grabbed | None = None
        self._number = 0

    def drag(self, pose: FloatArray, phase: Phase) -> None:
        """Take a pose (7,) of the gizmo; called in the order of the drag, and quick."""
        session = self._session
        if phase == "start" or self._grabbed is None:
            self._number += 1
            self._grabbed = self._grab(session.selected, pose)
        grabbed, number = self._grabbed, self._number
        snapped = self._snapped(grabbed, pose)
        is_over = phase == "end"
        self._view.is_dragging = not is_over
        self._view.move({grabbed.name: snapped})
        if session.table_of(grabbed.name) == "waypoint" and not is_over:
            self._watch.follow(snapped, begin=phase == "start")
        if phase == "update" or (is_over and not np.allclose(snapped, grabbed.start)):
            if grabbed.name != ROOT or is_over:
                session.post(lambda: self._commit(grabbed.name, snapped, number), "" if is_over else "drag")
        elif is_over:
            session.post(session.changed)
        if is_over:
            self._grabbed = None

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
        others = [body_triangles(spec, body, links) for body in spec.body if not _hangs_on(spec, body, name)]
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


def _hangs_on(spec: SceneSpec, thing: PosedSpec, name: str) -> bool:
    """Whether a thing is the one of that name, or moves with it."""
    parents = {other.name: other.parent.partition("/")[0] for other in spec.posed()}
    here = thing.name
    for _ in range(len(parents) + 1):
        if here == name:
            return True
        here = parents.get(here, "")
    return False
