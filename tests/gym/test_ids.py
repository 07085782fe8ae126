"""The ids of all tasks: known wherever the package is imported, and passed by gymnasium's checker."""

from __future__ import annotations

import subprocess
import sys
import warnings

import gymnasium
import pytest
from gymnasium.utils.env_checker import check_env

import rlbench_pin.gym
from rlbench_pin.gym.ids import ANY_TASK, MAX_EPISODE_STEPS, MODES, gym_id
from rlbench_pin.tasks import library_names, task_class, task_scene

IDS = [gym_id(task, mode) for task in library_names() for mode in MODES]
FEW = ("reach_target", "open_drawer", "stack_blocks")


def test_every_task_has_both_ids() -> None:
    """Each task of the library is registered for states and for images, with a limit of steps."""
    assert [i for i in IDS if i not in gymnasium.registry] == []
    ours = {i for i in gymnasium.registry if i.startswith("rlbench_pin/")}
    assert ours == {*IDS, ANY_TASK}
    assert {gymnasium.registry[i].max_episode_steps for i in IDS} == {MAX_EPISODE_STEPS}


def test_an_id_has_the_version_of_its_task() -> None:
    """Ids count from 0, so that version 1 has `-v0`; the ids that are registered have the versions of the scene files."""
    assert gym_id("open_drawer", "state", 3, "mine") == "mine/open_drawer-state-v2"
    assert {gym_id(n, m, task_scene(task_class(n)).version) for n in library_names() for m in MODES} == {
        i for i in gymnasium.registry if i.startswith("rlbench_pin/") and i != ANY_TASK
    }


@pytest.mark.simulation
@pytest.mark.parametrize("order", ["rlbench_pin, gymnasium", "gymnasium, rlbench_pin"])
def test_ids_appear_in_either_order_of_import_without_loading_tasks(order: str) -> None:
    """The ids are known whichever package comes first; neither a task nor a simulator is loaded for them."""
    code = (
        f"import {order}, sys; ids = [i for i in gymnasium.registry if i.startswith('rlbench_pin/')];"
        "heavy = [m for m in ('pybullet', 'pinocchio', 'rlbench_pin.tasks') if m in sys.modules];"
        "hooks = [f for f in sys.meta_path if type(f).__module__.startswith('rlbench_pin')];"
        "print(len(ids), heavy, hooks, type(gymnasium.__spec__.loader).__name__)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert result.stdout.split("\n")[0] == f"{len(IDS) + 1} [] [] SourceFileLoader", result.stderr
    assert result.stderr == ""


@pytest.mark.simulation
@pytest.mark.parametrize("module", ["rlbench_pin", "rlbench_pin.gym"])
def test_a_module_before_the_colon_is_imported(module: str) -> None:
    """Where nothing of ours was imported yet, the id brings the module that registers it."""
    code = f"import gymnasium; gymnasium.make('{module}:rlbench_pin/reach_target-state-v0').close(); print('made')"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert result.stdout == "made\n", result.stderr


def test_the_package_offers_the_environments() -> None:
    """Every public name of the package resolves; others are attribute errors."""
    front = rlbench_pin.gym
    assert list(front.__all__) == sorted(front.__all__)
    assert all(getattr(front, name) is not None and name in dir(front) for name in front.__all__)
    with pytest.raises(AttributeError, match="GymEnv"):
        _ = front.GymEnv  # type: ignore[attr-defined]


def test_an_unknown_id_proposes_the_nearest() -> None:
    """A misspelt id fails with gymnasium's own proposal."""
    with pytest.raises(gymnasium.error.NameNotFound, match="reach_target-state"):
        gymnasium.make("rlbench_pin/reach_targt-state-v0")


def checked(name: str) -> list[str]:
    """Run gymnasium's checker over an id and return its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        env = gymnasium.make(name).unwrapped
        check_env(env)
        env.close()
    return [str(w.message) for w in caught if "coal" not in str(w.message)]


@pytest.mark.simulation
@pytest.mark.parametrize("task", FEW)
def test_checker_has_nothing_to_say(task: str) -> None:
    """Gymnasium's checker passes without a warning."""
    assert checked(gym_id(task, "state")) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_checker_has_nothing_to_say_of_any_id(name: str) -> None:
    """Gymnasium's checker passes without a warning for every task, with and without images."""
    assert checked(name) == []
