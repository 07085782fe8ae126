"""Task files outside the package: run as they are, once, and refused with the reason."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rlbench_pin.errors import RlbenchPinError, TaskError, UnknownName
from rlbench_pin.tasks import find_task, is_task_file, load_task_file, own_tasks, task_class, task_digest, task_reference
from rlbench_pin.tasks.task_file import task_files

CLASS = """
from rlbench_pin.tasks import ListEmpty, Task


class {name}(Task):
    def init_task(self):
        self.register_success_conditions([ListEmpty([])])

    def init_episode(self, variation, rng):
        return ["Touch nothing."]
"""


def write_task(folder: Path, stem: str = "touch_nothing", code: str | None = None, scene: str = "format = 2\n") -> Path:
    """Write a pair of files and return the Python file."""
    folder.mkdir(parents=True, exist_ok=True)
    name = "".join(word.capitalize() for word in stem.split("_"))
    (folder / f"{stem}.toml").write_text(scene)
    file = folder / f"{stem}.py"
    file.write_text(CLASS.format(name=name) if code is None else code)
    return file


def test_an_unchanged_file_is_run_once_and_a_changed_one_again(tmp_path: Path) -> None:
    """The class stays the same object until the file changes; the file is found as text or path, from any folder."""
    file = write_task(tmp_path)
    first = find_task(str(file))
    assert first is find_task(file) is load_task_file(tmp_path / "x" / ".." / file.name)
    assert is_task_file(first) and not is_task_file(task_class("reach_target"))
    assert task_reference(first) == str(file) and task_reference(task_class("reach_target")) == "reach_target"
    before = task_digest(first)
    file.write_text(file.read_text() + "\n# changed\n")
    assert find_task(file) is not first
    assert task_digest(find_task(file)) != before
    assert task_digest(task_class("reach_target")) == ""


def test_nothing_is_written_beside_the_file_and_no_bytecode_is_taken(tmp_path: Path) -> None:
    """What runs is the text that one can read."""
    file = write_task(tmp_path)
    load_task_file(file)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["touch_nothing.py", "touch_nothing.toml"]


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("def f(:\n", "SyntaxError"),
        ("\n\nimport no_such_module\n", "ModuleNotFoundError: No module named 'no_such_module'. See its line 3"),
        ("raise SystemExit(3)\n", "SystemExit"),
        ("1 / 0\n", "ZeroDivisionError"),
        ("x = 1\n", "no class 'TouchNothing'"),
        ("TouchNothing = 3\n", "no class 'TouchNothing'"),
        ("\0", "cannot be loaded"),
        ("\xff", "cannot be loaded"),
        ("", "no class 'TouchNothing'"),
    ],
)
def test_a_file_that_cannot_be_loaded_is_refused_with_the_reason(code: str, says: str, tmp_path: Path) -> None:
    """Whatever the file raises becomes one kind of error, and no half of it stays behind."""
    file = write_task(tmp_path)
    file.write_bytes(code.encode("latin-1"))
    before = set(sys.modules)
    with pytest.raises(TaskError) as caught:
        find_task(file)
    assert says in str(caught.value) and str(file) in str(caught.value)
    assert not {name for name in set(sys.modules) - before if name.startswith("rlbench_pin_task_")}


def test_paths_that_are_no_task_files_are_refused(tmp_path: Path) -> None:
    """The nearest that works is named."""
    file = write_task(tmp_path)
    for path, says in {
        str(file.with_suffix("")): rf"Did you mean '{file}'",
        str(file.with_suffix(".toml")): "must end with `.py`",
        str(tmp_path): "does not exist",
        "nowhere/x.py": "rlbench-pin new",
    }.items():
        with pytest.raises(TaskError, match=says):
            find_task(path)
    with pytest.raises(UnknownName):
        find_task("touch_nothing")


def test_two_files_of_one_name_are_told_apart(tmp_path: Path) -> None:
    """Each has a class of its own; naming both at once is refused."""
    one, other = write_task(tmp_path / "a"), write_task(tmp_path / "b")
    assert find_task(one) is not find_task(other)
    assert list(own_tasks([one, one])) == ["touch_nothing"]
    with pytest.raises(TaskError, match="Two task files are called 'touch_nothing'"):
        own_tasks([one, other])


def test_models_of_its_own_belong_to_a_task(tmp_path: Path) -> None:
    """The URDF, its mesh, the material of the mesh and the picture of the material."""
    models = tmp_path / "models"
    models.mkdir()
    (models / "thing.urdf").write_text(
        '<robot name="thing"><link name="thing"><visual><geometry><mesh filename="thing.obj"/></geometry></visual></link></robot>'
    )
    (models / "thing.obj").write_text("mtllib thing.mtl\nv 0 0 0\n")
    (models / "thing.mtl").write_text("newmtl a\nmap_Kd thing.png\n")
    (models / "thing.png").write_bytes(b"png")
    (models / "other.png").write_bytes(b"png")
    scene = 'format = 2\n[[body]]\nname = "thing"\nasset = "./models/thing.urdf"\n'
    task = load_task_file(write_task(tmp_path, scene=scene))
    names = {"touch_nothing.py", "touch_nothing.toml", *(f"models/thing.{end}" for end in ("urdf", "obj", "mtl", "png"))}
    assert set(task_files(task)) == names


@pytest.mark.simulation
def test_a_dataclass_of_a_task_file_works_and_the_file_needs_no_package(tmp_path: Path) -> None:
    """Annotations are looked up in the module of the file; a process elsewhere loads it by its path."""
    code = (
        "from __future__ import annotations\nfrom dataclasses import dataclass\n"
        + CLASS.format(name="TouchNothing")
        + "\n\n@dataclass(frozen=True)\nclass Plan:\n    height: float = 0.1\n"
    )
    file = write_task(tmp_path, code=code)
    program = f"from rlbench_pin.tasks import find_task; print(find_task({str(file)!r}).get_name())"
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd="/", timeout=60)
    assert result.stdout == "touch_nothing\n", result.stderr


def test_all_refusals_are_ours(tmp_path: Path) -> None:
    """A folder called like a file, and a file that may not be read."""
    (tmp_path / "folder.py").mkdir()
    with pytest.raises(RlbenchPinError, match="does not exist"):
        find_task(tmp_path / "folder.py")
