"""What is wrong is said with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.builder.document import TaskDocument
from tests.builder.document.conftest import Opener

SCENE = """\
format = 2

[placement]
yaw = [-1.0, 1.0]

[[body]]
name = "cup"
asset = "objects/cup/cup.urdf"
color = [1.0, 0.0, 0.0]

[[frame]]
name = "a1"
poses = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 0.1],
]

[[frame]]
name = "goal"
parent = "cup"
rpy = [0.0, 0.0, 1.0]

[[waypoint]]
name = "waypoint0"
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("", "", None, ""),
        ('name = "cup"', 'name = "cup', 7, "not valid TOML"),
        ("[placement]", "[placement", 3, "not valid TOML"),
        ("[-1.0, 1.0]", "[1.0, -1.0]", 4, "above the upper bound"),
        ("[-1.0, 1.0]", "1.0", 4, "list"),
        ("yaw =", "jaw =", 4, "Did you mean 'yaw'?"),
        ("format = 2", "format = 3", 1, "not supported"),
        ("format = 2\n", "", 1, "missing"),
        ("[1.0, 0.0, 0.0]", "[1.0, 0.0]", 9, "color"),
        ("objects/cup/cup.urdf", "objects/cup/cap.urdf", 8, "does not exist"),
        ("color", "collor", 9, "Did you mean 'color'?"),
        ('asset = "objects/cup/cup.urdf"\n', "", 6, "missing"),
        ("    [0.0, 0.0, 0.1],", "    [0.0, 0.0],", 13, "pose"),
        ('name = "goal"', 'name = "cup"', 19, "used twice"),
        ('parent = "cup"', 'parent = "cap"', 20, "Did you mean 'cup'?"),
        ("rpy = [0.0, 0.0, 1.0]", "rpy = [0.0, 0.0, 90.0]", 21, "degrees"),
        ('"waypoint0"', '"waypoint1"', 23, "missing"),
        ("[[waypoint]]", "[[weypoint]]", 23, "not known"),
        ("[[waypoint]]\nname", "[[waypoint]]\ngripper = 2.0\nname", 24, "0..1"),
    ],
)
def test_problems_of_the_scene_point_to_the_line(tmp_path: Path, old: str, new: str, line: int | None, words: str) -> None:
    """Of the broken line, the key, or the table; no problem where nothing is wrong."""
    document = TaskDocument.new(tmp_path, "thing")
    document.set_scene_text(SCENE.replace(old, new, 1))
    found = [(problem.file, problem.line) for problem in document.problems]
    assert found == ([("scene", line)] if words else [])
    assert all(words in problem.message for problem in document.problems), document.problems


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("class ", "clas ", 10, "not valid Python"),
        ('self.world.body("block")', 'self.world.body("blok")', 15, "Did you mean 'block'?"),
        ('self.world.region("boundary")', 'self.world.region("block")', 17, "no region 'block'"),
        ('self.world.sensor("goal")', 'self.world.sensor("gaol")', 19, "Did you mean 'goal'?"),
        ('objects(["block"])', 'objects(["block", "brick"])', 18, "no body 'brick'"),
        ("class PickAndLift", "class PickUndLift", 10, "Name the class of the task after its file"),
    ],
)
def test_problems_of_the_python_point_to_the_line(opened: Opener, old: str, new: str, line: int, words: str) -> None:
    """Of what cannot be read, and of names that the scene lacks."""
    document = opened("pick_and_lift")
    assert old in document.python_text
    document.set_python_text(document.python_text.replace(old, new, 1))
    assert [(problem.file, problem.line) for problem in document.problems] == [("task", line)]
    assert words in document.problems[0].message, document.problems
    document.undo()
    assert document.problems == ()


def test_joints_and_frames_are_looked_up_as_the_world_does(opened: Opener) -> None:
    """Joints of URDF files that the scene does not speak of; waypoints, regions and sensors as frames; the room's bodies."""
    document = opened("open_box")
    lines = ('joint("carton/lid_hinge")', 'frame("waypoint0")', 'frame("root")', 'body("table")', 'joint("carton/lit_hinge")')
    added = "".join(f"        self.world.{line}\n" for line in lines)
    text = document.python_text
    document.set_python_text(text.replace("        self.register_success", f"{added}        self.register_success", 1))
    assert [problem.message for problem in document.problems] == [
        "The scene has no joint 'carton/lit_hinge'. Did you mean 'carton/lid_hinge'?"
    ]


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 5000,
        "x = a" + ".b" * 900,
        "x = 1" + " + 1" * 900,
        "x = " + "-" * 5000 + "1",
        "\0",
        "a = 1" + "0" * 9000,
        "[[body]]\n" * 3,
        "body = 3\nformat = 2",
    ],
)
def test_hostile_texts_are_problems(tmp_path: Path, text: str) -> None:
    """They are kept as they are typed, in both files, and can be undone."""
    document = TaskDocument.new(tmp_path, "thing")
    before = document.text
    document.set_scene_text(text)
    document.set_python_text(text)
    assert document.scene_text == document.python_text == text
    assert {problem.file for problem in document.problems} >= {"scene"}
    assert document.behaviour.success is None
    document.undo()
    document.undo()
    assert document.text == before and document.problems == ()
