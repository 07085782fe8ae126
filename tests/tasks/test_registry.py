"""Tasks by name."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import rlbench_pin.tasks as tasks
from rlbench_pin.errors import SceneFileError, TaskError, UnknownName
from rlbench_pin.tasks import Task, load_task_file, task_class, task_names, task_scene

NAMES = {
    "close_microwave", "meat_off_grill", "open_drawer", "pick_and_lift", "push_button", "put_rubbish_in_bin", "reach_target",
    "slide_block_to_target", "stack_blocks", "take_lid_off_saucepan",
}  # fmt: skip

OWN_TASK = """
from rlbench_pin.tasks import ListEmpty, Task


class TouchNothing(Task):
    def init_task(self):
        self.register_success_conditions([ListEmpty([])])

    def init_episode(self, variation, rng):
        return ["Touch nothing."]

    def variation_count(self):
        return 1
"""


def test_the_library_holds_the_first_ten_tasks_and_lists_all_in_alphabetical_order() -> None:
    """Each is a pair of files with one stem."""
    assert set(task_names()) >= NAMES
    assert list(task_names()) == sorted(task_names())


def test_a_task_is_found_by_either_name() -> None:
    """Snake case, camel case, or as an attribute of the package."""
    assert task_class("reach_target") is task_class("ReachTarget") is tasks.ReachTarget
    assert task_class("reach_target").get_name() == "reach_target"
    assert "ReachTarget" in dir(tasks)
    with pytest.raises(AttributeError, match="RaechTarget"):
        _ = tasks.RaechTarget


def test_an_unknown_task_is_answered_with_the_nearest() -> None:
    """And with the command that lists them all."""
    with pytest.raises(UnknownName, match=r"No task is called 'reach_taget'. Did you mean 'reach_target'\? `rlbench-pin list`"):
        task_class("reach_taget")


@pytest.mark.simulation
def test_only_the_asked_task_is_imported() -> None:
    """Listing and importing one leaves the others, and the simulator, alone."""
    code = (
        "import sys; from rlbench_pin.tasks import ReachTarget, task_names; task_names();"
        "assert not any(m.startswith('rlbench_pin.tasks.library.') and not m.endswith('reach_target') for m in sys.modules);"
        "assert 'pybullet' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(tasks.__file__).parents[2])


def test_a_scene_is_read_once() -> None:
    """The second time it is the same object."""
    assert task_scene(task_class("push_button")) is task_scene(task_class("push_button"))


def test_a_task_outside_the_package_brings_its_scene(tmp_path: Path) -> None:
    """The scene lies beside the file and is read again when it changes."""
    file = tmp_path / "touch_nothing.py"
    file.write_text(OWN_TASK)
    task = load_task_file(file)
    assert issubclass(task, Task)
    assert task.get_name() == "touch_nothing"
    with pytest.raises(SceneFileError, match=r"touch_nothing\.toml"):
        task_scene(task)
    file.with_suffix(".toml").write_text("format = 1")
    assert task_scene(task).waypoint == ()
    file.with_suffix(".toml").write_text('format = 1\n[[waypoint]]\nname = "waypoint0"')
    assert len(task_scene(task).waypoint) == 1


def test_a_file_without_its_class_is_refused(tmp_path: Path) -> None:
    """The class is named after the file."""
    with pytest.raises(TaskError, match="does not exist"):
        load_task_file(tmp_path / "none.py")
    (tmp_path / "other_name.py").write_text(OWN_TASK)
    with pytest.raises(TaskError, match="no class 'OtherName'"):
        load_task_file(tmp_path / "other_name.py")
