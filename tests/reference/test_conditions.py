"""The page about conditions and hooks has all of them, in the order in which they are called."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.environment import Environment, JointPositionActionMode
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.observation import Observation
from rlbench_pin.tasks import Condition, Task, conditions, task_class
from tests.reference.support import part, rows


def test_every_condition_is_on_the_page() -> None:
    """Each class of the package that is a condition has a heading."""
    headings = set(re.findall(r"^### (\w+)$", part("conditions", "conditions"), re.MULTILINE))
    classes = {name for name in conditions.__all__ if issubclass(getattr(conditions, name), Condition)}
    assert headings == classes - {"Condition"}


def test_every_method_of_a_task_is_on_the_page() -> None:
    """To override, to call, or called by the environment."""
    named = {
        row[0].split("(")[0] for marker in ("overridden", "called", "by-environment") for row in rows(part("conditions", marker))
    }
    methods = {name for name, thing in vars(Task).items() if inspect.isfunction(thing) and not name.startswith("_")}
    assert methods <= named


class Diary(task_class("push_button")):  # type: ignore[misc]
    """Notes what is called."""

    def __init__(self, world: object) -> None:
        super().__init__(world)
        self.calls: list[str] = []

    def init_task(self) -> None:
        """Note."""
        super().init_task()
        self.register_waypoint_ability_start(0, lambda _: self.calls.append("start hook"))
        self.register_waypoint_ability_end(0, lambda _: self.calls.append("end hook"))

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Note."""
        self.calls.append("init_episode")
        return super().init_episode(variation, rng)

    def base_rotation_bounds(self) -> object:
        """Note."""
        self.calls.append("place")
        return super().base_rotation_bounds()

    def reset_conditions(self) -> None:
        """Note."""
        super().reset_conditions()
        self.calls.append("reset_conditions")

    def step(self) -> None:
        """Note."""
        super().step()
        self.calls.append("step")

    def success(self) -> tuple[bool, bool]:
        """Note."""
        self.calls.append("conditions")
        return super().success()

    def decorate_observation(self, observation: Observation) -> Observation:
        """Note."""
        self.calls.append("observe")
        return observation

    def cleanup(self) -> None:
        """Note."""
        self.calls.append("cleanup")

    @classmethod
    def scene_file(cls) -> Path:
        """The scene of the task that is watched."""
        return task_class("push_button").scene_file()


@pytest.mark.simulation
def test_the_order_of_an_episode_is_that_of_the_page() -> None:
    """Layout, place, conditions from the settled instant; tick, conditions, observation; hooks around a segment; cleanup last."""
    with Environment(JointPositionActionMode(), obs_config=low_dim_config()) as environment:
        running = environment.get_task(Diary)
        diary = running.task
        assert isinstance(diary, Diary)
        running.reset(seed=0)
        assert [c for c in diary.calls if c != "reset_conditions"][-3:] == ["init_episode", "place", "observe"]
        assert diary.calls[-2] == "reset_conditions"
        diary.calls.clear()
        running.step(np.append(np.zeros(7), 0.04))
        assert diary.calls == ["step", "conditions", "observe"]
        diary.calls.clear()
        running.try_demo(seed=0, record=False)
        assert diary.calls[0] == "cleanup"
        assert diary.calls.index("start hook") < diary.calls.index("step") < diary.calls.index("end hook")
