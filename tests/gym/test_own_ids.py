"""Tasks of one's own as gymnasium environments: by their file, and by ids of their own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import gymnasium
import pytest

from rlbench_pin.cli.new import New
from rlbench_pin.errors import TaskEnvironmentError, TaskError, UnknownName
from rlbench_pin.gym import ANY_TASK, register_task
from rlbench_pin.gym.lerobot import make_env
from rlbench_pin.tasks import load_task_file, task_class, task_names


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A task file of one's own."""
    New("touch_it", tmp_path).run()
    return tmp_path / "touch_it.py"


@pytest.mark.simulation
def test_one_id_takes_every_task(mine: Path) -> None:
    """A file as text or path, a class, or a name; with the further arguments of any id."""
    for task in (str(mine), mine, load_task_file(mine), "touch_it" if "touch_it" in task_names() else "reach_target"):
        env = gymnasium.make(ANY_TASK, task=task, variation=1)
        _, info = env.reset(seed=3)
        assert info["variation"] == 1 and info["text_descriptions"]
        assert env.step(env.action_space.sample())[1] == 0.0
        env.close()


def test_what_is_no_task_is_refused(tmp_path: Path) -> None:
    """With our errors: no task, an unknown one, a file that is not there."""
    with pytest.raises(TaskEnvironmentError, match="No task was given"):
        gymnasium.make(ANY_TASK)
    with pytest.raises(UnknownName, match="reach_target"):
        gymnasium.make(ANY_TASK, task="reach_targt")
    with pytest.raises(TaskError, match="does not exist"):
        gymnasium.make(ANY_TASK, task=str(tmp_path / "x.py"))


@pytest.mark.simulation
def test_a_registered_task_has_ids_of_its_own(mine: Path) -> None:
    """For states and images; registering it again changes nothing, and no other task takes its ids."""
    ids = register_task(mine, "tests")
    try:
        assert ids == ("tests/touch_it-state-v0", "tests/touch_it-vision-v0")
        assert register_task(load_task_file(mine), "tests") == ids
        env = gymnasium.make(ids[0])
        assert env.reset(seed=1)[1]["text_descriptions"]
        env.close()
        New("touch_it", mine.parent / "other").run()
        with pytest.raises(TaskEnvironmentError, match="already belongs to another task"):
            register_task(mine.parent / "other" / "touch_it.py", "tests")
        scene = mine.with_suffix(".toml")
        scene.write_text(scene.read_text() + '\n[[history]]\nversion = 2\nchange = "The ball is smaller."\n')
        later = register_task(mine, "tests")
        assert later == ("tests/touch_it-state-v1", "tests/touch_it-vision-v1")
        ids += later
    finally:
        for name in ids:
            gymnasium.registry.pop(name, None)
    assert register_task("reach_target") == register_task(task_class("reach_target"))


@pytest.mark.simulation
def test_processes_of_their_own_load_the_file(mine: Path, tmp_path: Path) -> None:
    """Spawned environments are given the path, also where the class was registered."""
    program = tmp_path / "program.py"
    program.write_text(
        "import gymnasium\nfrom rlbench_pin.gym import register_task\nfrom rlbench_pin.tasks import load_task_file\n"
        "if __name__ == '__main__':\n"
        f"    name = register_task(load_task_file({str(mine)!r}))[0]\n"
        "    envs = gymnasium.make_vec(name, num_envs=2, vectorization_mode='async', vector_kwargs={'context': 'spawn'})\n"
        "    print(envs.reset(seed=[1, 2])[1]['text_descriptions'][0][0])\n    envs.close()\n"
    )
    result = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=120, cwd=tmp_path)
    assert "ball" in result.stdout, result.stderr


@pytest.mark.simulation
def test_lerobot_evaluates_a_file(mine: Path) -> None:
    """Its id comes after those of all names, so that theirs stay."""
    suite = make_env(1, tasks=[str(mine), "reach_target"], image_size=(16, 16), cameras=("front",))["rlbench_pin"]
    assert list(suite) == [len(task_names()), task_names().index("reach_target")]
    env = suite[len(task_names())]
    env.reset(seed=[0])
    assert env.call("task") == ("touch_it",)
    env.close()
