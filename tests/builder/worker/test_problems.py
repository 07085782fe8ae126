"""What is wrong is said of a file and a line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.builder.worker.problems import dumped_line
from tests.builder.worker.conftest import Copied, Opened

_PYTHON_ENDS = {
    "raise ValueError('boom')": ("ValueError: boom", 1),
    "import sys\nsys.exit(3)": ("SystemExit", 2),
    "def broken(:": ("SyntaxError", 1),
    "x = 1 / 0": ("ZeroDivisionError", 1),
    "def deep():\n    deep()\ndeep()": ("RecursionError", 2),
    "raise KeyboardInterrupt": ("KeyboardInterrupt", 1),
}


@pytest.mark.parametrize("ending", _PYTHON_ENDS)
def test_a_module_that_raises(copied: Copied, opened: Opened, ending: str) -> None:
    """The line of the module, in the words of the error."""
    text = copied("push_button")
    words, line = _PYTHON_ENDS[ending]
    (problem,) = opened(replace(text, python=f"{text.python}{ending}\n")).problems
    assert (problem.file, problem.line) == ("task", text.python.count("\n") + line)
    assert problem.message.startswith(words)


def test_a_task_that_raises_while_it_is_set_up(copied: Copied, opened: Opened) -> None:
    """The last line of the module, not that of the library that it called."""
    text = copied("push_button")
    (problem,) = opened(replace(text, python=text.python.replace('body("button")', 'body("buttom")'))).problems
    lines = text.python.splitlines()
    assert "Did you mean 'button'?" in problem.message
    assert problem.line is not None
    assert 'body("button")' in lines[problem.line - 1]


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("symmetry = 4\n", "symetry = 4\n", "symetry"),
        ("stiffness = 400.0", "stiffness = -1.0", "spring"),
        ("fixed = true", "fixed = maybe", "maybe"),
        ("[0.24, 0.24]", "[0.24]", "footprint"),
        ("objects/button/button.urdf", "objects/button/buton.urdf", "buton"),
        ("button/cap_joint", "button/cup_joint", "cup_joint"),
        ('parent = "button"', 'parent = "batton"', "batton"),
        ("format = 2 ", "format = 9 ", "format"),
    ],
)
def test_a_scene_that_is_wrong(copied: Copied, opened: Opened, old: str, new: str, found: str) -> None:
    """The line of the scene that holds the fault; the real folder is named, not the private one."""
    text = copied("push_button")
    scene = text.scene.replace(old, new, 1)
    for run_task in (True, False):
        (problem,) = opened(replace(text, scene=scene), run_task=run_task).problems
        assert problem.file == "scene"
        assert problem.line is not None, problem.message
        assert found in scene.splitlines()[problem.line - 1]


def test_a_class_of_another_name_concerns_the_whole_file(copied: Copied, opened: Opened) -> None:
    """There is no line to point at."""
    text = copied("push_button")
    (problem,) = opened(replace(text, python=text.python.replace("class PushButton", "class PushBotton"))).problems
    assert (problem.file, problem.line) == ("task", None)
    assert "PushButton" in problem.message


def test_a_stack_is_read_from_its_innermost_call() -> None:
    """As `faulthandler` writes it: the most recent call first."""
    calls = ("lib.py", 3), ("a.py", 7), ("a.py", 2)
    dump = "Stack (most recent call first):\n" + "\n".join(f'  File "/x/{file}", line {line} in f' for file, line in calls)
    assert dumped_line(dump, Path("/x/a.py")) == 7
    assert dumped_line(dump, Path("/x/b.py")) is None
