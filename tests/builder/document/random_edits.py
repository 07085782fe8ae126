"""Edits of all kinds, drawn at random."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rlbench_pin.builder.document import ConditionForm, DocumentError, Named, TaskDocument
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import PosedSpec

Edit = Callable[[TaskDocument, SceneSpec, np.random.Generator], object]


def _name(spec: SceneSpec, rng: np.random.Generator) -> str:
    return _one(spec.posed(), rng)


def _one(elements: Sequence[PosedSpec], rng: np.random.Generator) -> str:
    """Return the name of one of them, or one that nothing has."""
    return str(rng.choice([element.name for element in elements] or ["nothing"]))


def _pose(rng: np.random.Generator) -> list[float]:
    turn = rng.normal(size=4)
    return [*rng.uniform(-0.3, 0.3, 3), *(turn / np.linalg.norm(turn))]


def _move(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.set(_name(spec, rng), "pose", _pose(rng))


def _drag(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> None:
    name = _name(spec, rng)
    for _ in range(3):
        document.set(name, "pose", _pose(rng)[:3], merge=f"drag {name}")


def _reparent(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.set(_name(spec, rng), "parent", _name(spec, rng))


def _recolor(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.set(_one(spec.body, rng), "color", rng.uniform(0, 1, 3))


def _change_waypoint(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    name = f"waypoint{rng.integers(len(spec.waypoint) + 1)}"
    return document.set_several(name, {"gripper": float(rng.uniform()), "ignore_collisions": bool(rng.integers(2))})


def _add(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    values = {
        "body": {"asset": "objects/cube/cube.urdf"},
        "frame": {},
        "region": {"size": [0.1, 0.2, 0.0]},
        "sensor": {"shape": "sphere", "size": [0.0123456]},
        "waypoint": {"gripper": "open"},
    }
    table = str(rng.choice(sorted(values)))
    return document.add(table, {**values[table], "parent": _name(spec, rng) if spec.body else "root", "pose": _pose(rng)})


def _insert(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.insert_waypoint(int(rng.integers(len(spec.waypoint) + 1)), {"pose": _pose(rng)})


def _reorder(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.move_waypoint(_one(spec.waypoint, rng), int(rng.integers(len(spec.waypoint) + 1)))


def _attach(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.attach(_name(spec, rng), _name(spec, rng), _pose(rng))


def _duplicate(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.duplicate(_name(spec, rng))


def _delete(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.delete(_name(spec, rng), with_dependants=bool(rng.integers(2)))


def _rename(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    name = _one((*spec.body, *spec.frame, *spec.sensor), rng)
    return document.rename(name, f"element_{rng.integers(1000)}")


def _place(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    key, value = [("footprint", rng.uniform(0.1, 0.4, 2)), ("yaw", [-1.0, 1.0]), ("static", True)][rng.integers(3)]
    return document.set_placement(key, value)


def _type(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    place = int(rng.integers(len(document.scene_text)))
    document.set_scene_text(f"{document.scene_text[:place]}# typed\n{document.scene_text[place:]}")
    return document.undo() if document.spec != spec or document.problems else None


def _type_python(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.set_python_text(f"{document.python_text}\n# line {rng.integers(1000)}: ä\n")


def _say(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    return document.set_behaviour("title", f"Title {rng.integers(1000)}.")


def _succeed(document: TaskDocument, spec: SceneSpec, rng: np.random.Generator) -> object:
    body = Named("body", _one(spec.body, rng))
    return document.set_behaviour("success", [*(document.behaviour.success or ()), ConditionForm("Grasped", {"body": body})])


EDITS: tuple[Edit, ...] = (
    _move, _drag, _reparent, _recolor, _change_waypoint, _add, _insert, _reorder, _attach, _duplicate, _delete, _rename,
    _place, _type, _type_python, _say, _succeed,
)  # fmt: skip


def edit_at_random(document: TaskDocument, count: int, rng: np.random.Generator) -> set[str]:
    """Make edits until `count` have changed something, and return the names of those kinds that have.

    Edits that a document refuses, with an error of ours and without any change, are drawn anew.
    """
    kinds: set[str] = set()
    made = 0
    while made < count:
        spec, texts, step = document.spec, (document.scene_text, document.python_text), document.step
        assert spec is not None
        edit = EDITS[rng.integers(len(EDITS))]
        try:
            edit(document, spec, rng)
        except (DocumentError, RlbenchPinError):
            if edit is not _drag:
                assert (document.scene_text, document.python_text, document.step) == (*texts, step)
            continue
        if (document.scene_text, document.python_text) != texts:
            made += 1
            kinds.add(edit.__name__)
    return kinds
