"""Edits of the scene by forms: what is written, and what keeps its bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.builder.document import EditRefused, TaskDocument
from rlbench_pin.errors import InvalidValue, RlbenchPinError, SceneFileError, UnknownName
from rlbench_pin.spatial import TABLE_HEIGHT
from tests.builder.document.conftest import Opener

SCENE = """\
# A scene by hand.
format = 2

[placement]
pose = [0.3, 0.0, 0.0]                      # in front

[[body]]
name = "cup"                                # the cup
asset = "objects/cup/cup.urdf"
pose = [0.1, -0.12345, 0.05]                # on the table
color = [1.0, 0.0, 0.0]   # red

# Where it goes.
[[frame]]
name = "goal"
parent = "cup"
rpy = [3.1415927, 0.0, 0.5]

[[waypoint]]
name = "waypoint0"
parent = "goal"
"""


@pytest.fixture
def document(tmp_path: Path) -> TaskDocument:
    """Return a small task whose scene is `SCENE`."""
    document = TaskDocument.new(tmp_path, "thing")
    document.set_scene_text(SCENE)
    assert document.problems == ()
    return document


def _changes(document: TaskDocument) -> tuple[list[str], list[str]]:
    """Return the lines of `SCENE` that are gone, and those that have come."""
    before, after = SCENE.splitlines(), document.scene_text.splitlines()
    return [line for line in before if line not in after], [line for line in after if line not in before]


def test_one_coordinate_changes_in_place(document: TaskDocument) -> None:
    """The others keep their digits, and the comment its column."""
    document.set("cup", "pose", [0.20004, -0.12345, 0.05, 0.0, 0.0, 0.0, 1.0])
    assert _changes(document) == (
        ["pose = [0.1, -0.12345, 0.05]                # on the table"],
        ["pose = [0.2, -0.12345, 0.05]                # on the table"],
    )


@pytest.mark.parametrize(
    ("turn", "lines"),
    [
        ((0, 0, 0, 1), []),
        ((0, 0, np.sin(0.15), np.cos(0.15)), ["pose = [0.1, -0.12345, 0.05, 0.3]           # on the table"]),
        ((0, 0, -np.sqrt(0.5), -np.sqrt(0.5)), ["pose = [0.1, -0.12345, 0.05, 1.5707963]     # on the table"]),
        ((1, 0, 0, 1e-9), ["rpy = [3.1415927, 0.0, 0.0]"]),
        ((0, np.sqrt(0.5), 0, np.sqrt(0.5)), ["rpy = [0.0, 1.5707963, 0.0]"]),
    ],
)
def test_a_rotation_is_written_in_the_shortest_way(document: TaskDocument, turn: tuple[float, ...], lines: list[str]) -> None:
    """Nothing, a yaw, or angles; right angles to seven digits."""
    turn = tuple(np.array(turn) / np.linalg.norm(turn))
    document.set("cup", "pose", [0.1, -0.12345, 0.05, *turn])
    assert _changes(document)[1] == lines
    assert document.spec is not None
    assert abs(np.dot(document.spec.body[0].pose[3:], turn)) == pytest.approx(1.0, abs=1e-7)


def test_a_position_leaves_the_angles_alone(document: TaskDocument) -> None:
    """And a pose that is only turned gets no position; one that is turned back no angles."""
    assert document.spec is not None
    document.set("goal", "pose", [0.0, 0.1, 0.0, *document.spec.frame[0].pose[3:]])
    assert _changes(document) == ([], ["pose = [0.0, 0.1, 0.0]"])
    document.set("goal", "pose", [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert _changes(document) == (["rpy = [3.1415927, 0.0, 0.5]"], ["rpy = [3.1415927, 0.0, 0.0]"])
    document.set("goal", "pose", None)
    assert _changes(document) == (["rpy = [3.1415927, 0.0, 0.5]"], [])


def test_random_poses_are_kept_to_the_digits_that_are_written(document: TaskDocument) -> None:
    """To 0.05 mm and 0.2 mrad, near poles of the angles, too."""
    rng = np.random.default_rng(0)
    for k in range(60):
        turn = rng.normal(size=4) if k % 3 else np.array([*rng.normal(size=2), *rng.normal(size=2)]) * [1e-4, 1, 1e-4, 1]
        pose = [*rng.uniform(-0.5, 0.5, 3), *(turn / np.linalg.norm(turn))]
        document.set("cup", "pose", pose)
        assert document.spec is not None
        kept = np.array(document.spec.body[0].pose)
        assert np.abs(kept[:3] - pose[:3]).max() <= 5.1e-5
        assert 2.0 * np.arccos(min(1.0, abs(kept[3:] @ pose[3:]))) < 2.5e-4


def test_keys_come_and_go_in_their_places(document: TaskDocument) -> None:
    """In the order of the library; what is at its default is not said."""
    document.set("cup", "fixed", True)
    document.set("cup", "scale", 2)
    document.set("cup", "collides", True)
    assert "pose = [0.1, -0.12345, 0.05]                # on the table\nfixed = true\ncolor = [1.0" in document.scene_text
    assert "color = [1.0, 0.0, 0.0]   # red\nscale = 2.0\n" in document.scene_text and "collides" not in document.scene_text
    document.set("cup", "color", np.array([0.123456, 0.5, 1.0]))
    assert "color = [0.1235, 0.5, 1.0]" in document.scene_text
    document.set("cup", "color", None)
    document.set("cup", "scale", 1.0)
    document.set("cup", "fixed", False)
    assert _changes(document) == (["color = [1.0, 0.0, 0.0]   # red"], [])


def test_a_curve_takes_two_keys_at_once(document: TaskDocument) -> None:
    """A scene that is valid stays so; half a curve is refused with the reason, and nothing changes."""
    with pytest.raises(SceneFileError, match="a curve needs either"):
        document.set("waypoint0", "path", "curve")
    assert document.scene_text == SCENE
    document.set_several("waypoint0", {"path": "curve", "arc": {"axis": [0, 0, 1], "angle": -1.57079, "twist": True}})
    assert 'path = "curve"\narc = { axis = [0.0, 0.0, 1.0], angle = -1.5707963 }\n' in document.scene_text
    document.set_several("waypoint0", {"arc": None, "points": [[0, 0, 0.1], [0, 0, 0.2, 1, 0, 0, 0]]})
    assert "points = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.2, 1.0, 0.0, 0.0, 0.0]]\n" in document.scene_text


@pytest.mark.parametrize(
    ("edit", "error"),
    [
        (("cup", "pose", [1, 2]), InvalidValue),
        (("cup", "pose", [0, 0, float("nan")]), RlbenchPinError),
        (("cup", "pose", [999, 0, 0]), RlbenchPinError),
        (("cup", "color", [2, 0, 0]), SceneFileError),
        (("cup", "parent", "goal"), SceneFileError),
        (("cup", "parent", "plate"), SceneFileError),
        (("cup", "asset", "objects/none.urdf"), RlbenchPinError),
        (("cup", "colour", [1, 0, 0]), UnknownName),
        (("cup", "name", "mug"), EditRefused),
        (("mug", "fixed", True), UnknownName),
        (("cup/handle", "friction", 1.0), SceneFileError),
    ],
)
def test_what_would_break_the_scene_is_refused(document: TaskDocument, edit: tuple, error: type[Exception]) -> None:
    """With an error that says why; the text, the undo list and the step stay."""
    step = document.step
    with pytest.raises(error):
        document.set(*edit)
    assert document.scene_text == SCENE and document.step == step


def test_new_things_stand_behind_those_of_their_table(document: TaskDocument) -> None:
    """Under a free name; a table that is not there yet comes in the order of the library."""
    assert document.add("body", {"asset": "objects/cup/cup.urdf"}) == "cup_2"
    assert document.add("sensor", {"shape": "sphere", "size": [0.0004567]}) == "sensor"
    assert document.add("waypoint", {"parent": "cup", "gripper": 0.5}) == "waypoint1"
    headings = [line for line in document.scene_text.splitlines() if line.startswith("[[")]
    assert headings == ["[[body]]", "[[body]]", "[[frame]]", "[[sensor]]", "[[waypoint]]", "[[waypoint]]"]
    assert 'asset = "objects/cup/cup.urdf"\n\n# Where it goes.\n[[frame]]' in document.scene_text
    assert "size = [0.00046]\n" in document.scene_text
    assert _changes(document)[0] == []
    for name in ("sensor", "waypoint1", "cup_2"):
        document.delete(name)
    assert document.scene_text == SCENE


def test_the_placement_is_meant_in_the_world(document: TaskDocument) -> None:
    """The file counts heights from the table top."""
    document.set_placement("pose", [0.25, 0.1, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0])
    document.set_placement("footprint", (0.4, 0.3))
    assert _changes(document)[1] == ["pose = [0.25, 0.1, 0.0]                     # in front", "footprint = [0.4, 0.3]"]
    assert document.spec is not None and document.spec.placement.pose[2] == TABLE_HEIGHT


def test_a_duplicate_says_the_same_under_another_name(opened: Opener) -> None:
    """A body with its joints; a waypoint right behind, with all later ones renumbered."""
    document = opened("open_drawer")
    before = document.spec
    assert document.duplicate("chest") == "chest_2" and document.duplicate("waypoint1") == "waypoint2"
    assert before is not None and document.spec is not None
    assert document.spec.body[1] == before.body[0].model_copy(update={"name": "chest_2"})
    assert [j.name for j in document.spec.joint][3:] == ["chest_2/drawer_bottom", "chest_2/drawer_middle", "chest_2/drawer_top"]
    assert document.spec.waypoint[2] == before.waypoint[1].model_copy(update={"name": "waypoint2"})
    assert document.spec.waypoint[3] == before.waypoint[2].model_copy(update={"name": "waypoint3"})
    with pytest.raises(EditRefused, match="Duplicate its body"):
        document.duplicate("chest/drawer_top")


def test_a_joint_is_described_when_a_form_changes_it(opened: Opener) -> None:
    """Also one that the file does not speak of yet."""
    document = opened("open_box")
    spec = document.spec
    assert spec is not None
    document.set("carton/lid_hinge", "spring", {"stiffness": 2.0, "rest": 0.0})
    assert "spring = { stiffness = 2.0 }" in document.scene_text


def test_tables_on_one_line_are_left_to_people(document: TaskDocument) -> None:
    """They have no place of their own for new entries; the error says what to write instead."""
    document.set_scene_text('format = 2\nframe = [{ name = "a" }]\nplacement = { static = true }\n')
    with pytest.raises(EditRefused, match=r"Write \[\[frame\]\]"):
        document.add("frame", {})
    with pytest.raises(EditRefused, match=r"Write \[placement\]"):
        document.set_placement("static", False)


def test_a_scene_that_is_not_valid_can_be_mended_by_forms(document: TaskDocument) -> None:
    """The last valid scene stays in sight; one that is no TOML is mended as text first."""
    document.set_scene_text(SCENE.replace("[1.0, 0.0, 0.0]", "[9.0, 0.0, 0.0]"))
    assert document.problems and document.spec is not None and document.spec.body[0].color == (1.0, 0.0, 0.0)
    document.set("cup", "color", [0.5, 0.0, 0.0])
    assert not document.problems and document.spec.body[0].color == (0.5, 0.0, 0.0)
    document.set_scene_text("format = ")
    with pytest.raises(EditRefused, match="Correct the text first"):
        document.set("cup", "color", None)


def test_a_file_of_format_1_keeps_its_ways(document: TaskDocument) -> None:
    """No angles, and heights in the world."""
    document.set_scene_text('format = 1\n\n[placement]\nstatic = true\n\n[[frame]]\nname = "a"\n')
    document.set("a", "pose", [0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0])
    document.set_placement("pose", [0.25, 0.0, 0.8])
    assert "pose = [0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0]\n" in document.scene_text
    assert "[placement]\npose = [0.25, 0.0, 0.8]\nstatic = true\n" in document.scene_text


STYLES = """\
format = 2

[[ body ]]   # a [[frame]] in a comment
"name" = 'lamp'
asset = "objects/desk_lamp/desk_lamp.urdf"
pose = [ # where
    0.1,  # x
    0.2,
    0.0 ]

[[joint]]
name = "LAMP/JOINT"
[joint.spring]
stiffness = 1.0

[[frame]]
name = "a"

[[waypoint]]
name = "waypoint0"
path = "curve"
arc.axis = [0.0, 0.0, 1.0]
arc.angle = 1.0

[[deviation]]
name = "words"
specified = '''
[[frame]]
name = "b" # ]'''
here = "a \\" # [ {"
reason = \"\"\"
x = 1\"\"\"
"""


def test_other_ways_to_write_the_same_are_understood(document: TaskDocument) -> None:
    """Comments within lists, tables within entries, dotted keys, headings within texts."""
    body, joint = "carton", "carton/lid_hinge"
    text = STYLES.replace("lamp'", f"{body}'").replace("objects/desk_lamp/desk_lamp.urdf", "objects/carton/carton.urdf")
    document.set_scene_text(text.replace("LAMP/JOINT", joint))
    assert document.problems == (), document.problems
    before = document.scene_text
    document.set(body, "pose", [0.1, 0.25, 0.0])
    assert document.scene_text == before.replace("0.2,", "0.25,")
    document.set(joint, "friction", 0.5)
    assert f'name = "{joint}"\nfriction = 0.5\n[joint.spring]' in document.scene_text
    document.set(joint, "spring", {"stiffness": 2.0})
    assert "friction = 0.5\nspring = { stiffness = 2.0 }\n\n[[frame]]" in document.scene_text
    document.set("waypoint0", "arc", {"axis": [0.0, 0.0, 1.0], "angle": 0.5})
    assert 'path = "curve"\narc = { axis = [0.0, 0.0, 1.0], angle = 0.5 }\n\n[[deviation]]' in document.scene_text
    document.rename("a", "c")
    document.add("frame", {})
    assert 'name = "c"\n\n[[frame]]\nname = "frame"\n\n[[waypoint]]' in document.scene_text
    assert document.scene_text.endswith(before[before.index("[[deviation]]") :]) and document.problems == ()


@pytest.mark.parametrize("value", ["abc", 3, None, [[1]], {"x": 1}, object(), [None] * 3, [True, False, True], "\ud800"])
@pytest.mark.parametrize("key", ["pose", "points", "arc", "parent", "gripper"])
def test_values_of_any_kind_are_refused_in_our_words(document: TaskDocument, key: str, value: object) -> None:
    """Or they are the default, or the value is one that can be."""
    before = document.scene_text
    try:
        document.set("waypoint0", key, value)
    except RlbenchPinError:
        assert document.scene_text == before
    assert document.problems == ()


# Arrays of elements -----------------------------------------------------------------------------------------------------------


def test_a_pose_changes_within_the_array(opened: Opener) -> None:
    """One element of the list, and nothing else."""
    document = opened("setup_checkers")
    before = document.scene_text
    document.set("piece5", "pose", [-0.12, -0.023, 0.021, 0.0, 0.0, 0.0, 1.0])
    assert document.scene_text == before.replace("[-0.115, -0.023, 0.021]", "[-0.12, -0.023, 0.021]")
    document.set("piece5", "pose", [-0.115, -0.023, 0.021, 1.0, 0.0, 0.0, 0.0])
    assert "[-0.115, -0.023, 0.021, 1.0, 0.0, 0.0, 0.0]" in document.scene_text


@pytest.mark.parametrize(("name", "entries"), [("piece0", 2), ("piece1", 3), ("piece5", 3), ("piece11", 2)])
def test_another_key_splits_the_array(opened: Opener, name: str, entries: int) -> None:
    """What is before and behind stays an array; all elements are as they were, but for the one."""
    document = opened("setup_checkers")
    before, text = document.spec, document.scene_text
    document.set(name, "color", [1.0, 0.0, 0.0])
    assert before is not None and document.spec is not None
    assert document.scene_text.count("[[body]]") == text.count("[[body]]") - 1 + entries
    for old, new in zip(before.body, document.spec.body, strict=True):
        assert new == (old.model_copy(update={"color": (1.0, 0.0, 0.0)}) if old.name == name else old)
    assert document.scene_text.count("to piece11, one for each pose") == 1


@pytest.mark.parametrize("name", ["piece0", "piece5", "piece10", "piece11"])
def test_one_of_an_array_is_deleted_or_renamed(opened: Opener, name: str) -> None:
    """The others keep names and places."""
    document = opened("setup_checkers")
    before = document.spec
    assert before is not None
    document.rename(name, "king")
    assert document.spec is not None
    assert [body.name for body in document.spec.body] == [("king" if b.name == name else b.name) for b in before.body]
    document.undo()
    document.delete(name, with_dependants=True)
    assert document.spec is not None
    assert list(document.spec.body) == [body for body in before.body if body.name != name]


def test_a_duplicate_counts_on(opened: Opener) -> None:
    """A numbered element gets the next number that is free, and its own entry."""
    document = opened("setup_checkers")
    assert document.duplicate("piece3") == "piece24"
    assert document.spec is not None and document.spec.body[-1].pose == document.spec.body[4].pose


def test_an_array_with_angles_keeps_them(opened: Opener) -> None:
    """A pose without another rotation changes in place; one that is turned gets an entry of its own."""
    document = opened("setup_checkers")
    document.set_scene_text(
        'format = 2\n\n[[frame]]\nname = "a1"\nposes = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]]\nrpy = [3.1415927, 0.0, 0.0]\n'
    )
    document.set("a2", "pose", [0.0, 0.1, 0.2, 1.0, 0.0, 0.0, 0.0])
    assert "poses = [[0.0, 0.0, 0.1], [0.0, 0.1, 0.2]]\n" in document.scene_text
    document.set("a1", "pose", [0.0, 0.0, 0.1])
    assert document.scene_text.startswith(
        'format = 2\n\n[[frame]]\nname = "a1"\npose = [0.0, 0.0, 0.1]\n\n[[frame]]\nname = "a2"\n'
    )
