"""Edits that concern several elements or both files: renaming, numbering, deleting, attaching."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.builder.document import EditRefused, HasDependants
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import compose, inverse
from rlbench_pin.viewer.places import places_at_rest
from tests.builder.document.conftest import Opener


def test_a_body_is_renamed_everywhere(opened: Opener) -> None:
    """In the scene with parents and joints, in the Python as a text or before a slash; other mentions are told."""
    document = opened("open_drawer")
    python = document.python_text
    left = document.rename("chest", "commode")
    lines = [line.split("#")[0] for line in document.scene_text.splitlines() if not line.startswith('    "')]  # sentences stay
    texts = "\n".join(lines).replace("objects/chest/chest.urdf", "")
    assert "chest" not in texts
    assert document.spec is not None and document.problems == ()
    assert [joint.name for joint in document.spec.joint] == [f"commode/drawer_{which}" for which in ("bottom", "middle", "top")]
    assert 'self.world.joint(f"chest/drawer_{drawer}")' in document.python_text
    assert any('f"chest/drawer_{drawer}"' in line for line in left)
    assert left == document.left
    document.undo()
    assert document.python_text == python


def test_texts_of_the_python_are_renamed_and_the_rest_is_told(opened: Opener) -> None:
    """Line and content of what was left."""
    document = opened("pick_and_lift")
    left = document.rename("block", "brick")
    assert 'self.world.body("brick")' in document.python_text and 'objects(["brick"])' in document.python_text
    assert document.problems == ()
    assert any(line.startswith("15: ") and "self.block" in line for line in left)
    assert not any(line.endswith('register_graspable_objects(["brick"])') for line in left)


@pytest.mark.parametrize("new", ["target", "marker", "Brick", "table", "a b", ""])
def test_a_name_that_cannot_be_is_refused(opened: Opener, new: str) -> None:
    """One that is taken, reserved or none."""
    document = opened("pick_and_lift")
    texts = document.text
    with pytest.raises(RlbenchPinError):
        document.rename("block", new if new != "target" else "marker")
    assert document.text == texts and document.step == 0


def test_waypoints_are_renumbered_wherever_they_are_named(opened: Opener) -> None:
    """As parents, as texts, as numbers of hooks; what is before keeps its number."""
    document = opened("stack_blocks")
    before = document.spec
    assert before is not None and "register_waypoint_ability_start(3, " in document.python_text
    assert document.insert_waypoint(2, {"parent": "waypoint3", "pose": [0.0, 0.0, -0.2]}) == "waypoint2"
    assert document.spec is not None and document.problems == ()
    names = [waypoint.name for waypoint in document.spec.waypoint]
    assert names == [f"waypoint{k}" for k in range(len(before.waypoint) + 1)]
    assert document.spec.waypoint[2].parent == "waypoint4"
    for old in before.waypoint:
        number = int(old.name.removeprefix("waypoint"))
        new = document.spec.waypoint[number + (number >= 2)]
        assert new.pose == old.pose and new.gripper == old.gripper
    for line in ("start(0, self._aim", "start(4, self._rise", "start(6, self._stay", 'frame("waypoint1")'):
        assert line in document.python_text
    document.delete("waypoint2")
    assert document.spec == before and "start(3, self._rise" in document.python_text


def test_a_waypoint_between_others_keeps_the_order(opened: Opener) -> None:
    """A copy is visited right after its original; where the Python computes numbers, only a copy of the last one is made."""
    document = opened("stack_blocks")
    before = document.spec
    assert before is not None
    for number, waypoint in enumerate(before.waypoint):
        assert document.duplicate(waypoint.name) == f"waypoint{number + 1}"
        assert document.spec is not None
        places = [*range(number + 1), *range(number, len(before.waypoint))]
        assert [w.pose for w in document.spec.waypoint] == [before.waypoint[k].pose for k in places]
        document.undo()
    document.set_python_text(document.python_text + '\n\ndef name_of(i: int) -> str:\n    return f"waypoint{i}"\n')
    texts, last = document.text, len(before.waypoint) - 1
    for edit in (lambda: document.duplicate("waypoint0"), lambda: document.insert_waypoint(0, {})):
        with pytest.raises(EditRefused, match="computes which waypoint"):
            edit()
        assert document.text == texts
    assert document.duplicate(f"waypoint{last}") == f"waypoint{last + 1}"


@pytest.mark.parametrize(("old", "new"), [(0, 3), (3, 0), (1, 2), (2, 1), (2, 0)])
def test_a_waypoint_moves_to_another_number(opened: Opener, old: int, new: int) -> None:
    """In both files: names, parents, texts and numbers; what is said of it stands there in the file; undone to the byte."""
    document = opened("place_cups")
    before, texts = document.spec, (document.scene_text, document.python_text)
    assert before is not None and len(before.waypoint) > 4
    assert document.move_waypoint(f"waypoint{old}", new) == f"waypoint{new}"
    order = [f"waypoint{k}" for k in range(len(before.waypoint))]
    order.insert(new, order.pop(old))
    called = {name: f"waypoint{k}" for k, name in enumerate(order)}
    by_name = {waypoint.name: waypoint for waypoint in before.waypoint}
    assert document.spec is not None
    for now in document.spec.waypoint:
        was = by_name[next(name for name, value in called.items() if value == now.name)]
        assert (now.pose, now.gripper, now.path) == (was.pose, was.gripper, was.path)
        assert now.parent == called.get(was.parent, was.parent)
    assert [waypoint.name for waypoint in document.spec.waypoint] == [f"waypoint{k}" for k in range(len(order))]
    assert f'self.world.frame("{called["waypoint1"]}").set_parent(f"mug' in document.python_text
    assert f"ability_start({called['waypoint0'].removeprefix('waypoint')}, self._aim" in document.python_text
    document.undo()
    assert (document.scene_text, document.python_text) == texts
    document.redo()
    document.move_waypoint(f"waypoint{new}", old)
    assert document.spec == before and (document.scene_text, document.python_text) == texts


@pytest.mark.parametrize("line", ['f"waypoint{i}"', "self.get_waypoint(i)", "waypoint.index == 0", "self.get_waypoints()[-1]"])
def test_waypoints_that_the_python_computes_are_not_reordered(opened: Opener, line: str) -> None:
    """Nobody can say what it would mean afterwards; the line is named, and nothing has changed."""
    document = opened("stack_blocks")
    document.set_python_text(f"{document.python_text}\n\ndef which(self, i, waypoint):\n    return {line}\n")
    texts = document.text
    with pytest.raises(EditRefused, match="computes which waypoint") as refused:
        document.move_waypoint("waypoint0", 1)
    assert line in str(refused.value) and document.text == texts
    with pytest.raises(RlbenchPinError, match="number of a waypoint"):
        document.move_waypoint("waypoint0", 99)
    with pytest.raises(EditRefused, match="not a waypoint"):
        document.move_waypoint(document.spec.body[0].name, 0)  # type: ignore[union-attr]


def test_what_others_need_is_not_deleted_without_them(opened: Opener) -> None:
    """The error lists what hangs on it, its joints, and the lines of Python that name it."""
    document = opened("open_drawer")
    with pytest.raises(HasDependants) as refused:
        document.delete("chest")
    assert refused.value.dependants == (
        *("chest/drawer_bottom", "chest/drawer_middle", "chest/drawer_top"),
        *("handle_bottom", "handle_middle", "handle_top"),
    )
    assert len(refused.value.mentions) == 1 and "drawer_{drawer}" in refused.value.mentions[0]
    assert document.step == 0
    document.delete("chest", with_dependants=True)
    assert document.spec is not None and not document.spec.body and not document.spec.joint and not document.spec.frame
    assert any("drawer_{drawer}" in line for line in document.left)
    assert len(document.spec.waypoint) == 3


def test_waypoints_go_with_those_on_which_they_hang(opened: Opener) -> None:
    """What is left is numbered without gaps."""
    document = opened("setup_checkers")
    before = document.spec
    document.delete("waypoint1", with_dependants=True)
    assert before is not None and document.spec is not None
    assert [waypoint.name for waypoint in document.spec.waypoint] == ["waypoint0", "waypoint1", "waypoint2"]
    assert [waypoint.pose for waypoint in document.spec.waypoint] == [waypoint.pose for waypoint in before.waypoint[3:]]
    assert [waypoint.parent for waypoint in document.spec.waypoint] == ["waypoint1", "square0", "waypoint1"]


def test_names_are_not_changed_in_python_that_cannot_be_read(opened: Opener) -> None:
    """It has to be mended first."""
    document = opened("open_drawer")
    document.set_python_text("def (")
    with pytest.raises(EditRefused, match="line 1.*Correct it first"):
        document.rename("chest", "commode")


# Attaching --------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "task", ["pick_and_lift", pytest.param("setup_checkers", marks=pytest.mark.simulation), "open_drawer", "stack_blocks"]
)
def test_the_place_in_the_world_is_kept(opened: Opener, task: str) -> None:
    """Whatever is hung on whatever, however it is turned; undone, the bytes are those of before."""
    document, rng = opened(task), np.random.default_rng(3)
    turned = np.concatenate([rng.uniform(-0.2, 0.2, 3), rng.normal(size=4)])
    turned[3:] /= np.linalg.norm(turned[3:])
    assert document.spec is not None
    document.set(document.spec.body[-1].name, "pose", turned)
    hung = 0
    for name in [thing.name for thing in document.spec.posed()]:
        for parent in ["root", *(body.name for body in document.spec.body)]:
            before, text = places_at_rest(document.spec), document.text
            here, frame = before.of(name), before.of(parent)
            assert here is not None and frame is not None
            try:
                document.attach(name, parent, compose(inverse(frame), here))
            except RlbenchPinError:  # it hangs on itself
                assert document.text == text
                continue
            after = places_at_rest(document.spec).of(name)
            assert after is not None
            turn = min(np.abs(after[3:] - here[3:]).max(), np.abs(after[3:] + here[3:]).max())
            assert np.abs(after[:3] - here[:3]).max() < 1e-9 and turn < 1e-9
            assert next(t for t in document.spec.posed() if t.name == name).parent == parent
            if document.text != text:
                hung += 1
                document.undo()
            assert document.text == text
    assert hung > 5


def test_what_cannot_hang_is_refused(opened: Opener) -> None:
    """On itself, on what hangs on it, on nothing that there is; joints hang on nothing."""
    document = opened("open_drawer")
    text = document.text
    for name, parent in (("chest", "chest"), ("chest", "handle_top"), ("waypoint0", "nowhere")):
        with pytest.raises(RlbenchPinError, match=parent):
            document.attach(name, parent, [0.0, 0.0, 0.0])
    with pytest.raises(EditRefused, match="no pose"):
        document.attach("chest/drawer_top", "root", [0.0, 0.0, 0.0])
    assert document.text == text


def test_short_numbers_stay_short(opened: Opener) -> None:
    """Digits that say nothing are not written."""
    document = opened("pick_and_lift")
    document.attach("block", "marker", [0.1, 0.2, -0.0225])
    assert 'parent = "marker"\npose = [0.1, 0.2, -0.0225]\n' in document.scene_text
    document.attach("block", "root", [0.0, 0.0, 0.0])
    assert document.scene_text.count('parent = "marker"') == 2
