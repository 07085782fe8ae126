"""One task, ready to be reset, stepped and demonstrated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from rlbench_pin.environment.actions.action_mode import ActionMode
from rlbench_pin.environment.demonstrate import DemoOutcome, DemoPlayer, try_play
from rlbench_pin.environment.episode_seeds import EpisodeRandom
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.randomization.randomizer import Randomizer
from rlbench_pin.environment.randomization.sample import RandomizationSample
from rlbench_pin.environment.reset import start_episode
from rlbench_pin.environment.runtime import Runtime, RuntimeState
from rlbench_pin.environment.stored import read_stored_demos
from rlbench_pin.errors import DemoError, NotReset, TaskEnvironmentError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.tasks import Task

if TYPE_CHECKING:
    from rlbench_pin.sim import World

MAX_DEMO_ATTEMPTS = 10
ALL_VARIATIONS = -1
_LIBRARIES = ("rlbench_pin", "pin", "coal", "pybullet", "ompl", "toppra", "placo", "osqp", "numpy")


@dataclass(frozen=True)
class EnvironmentState:
    """A moment of an episode, to go back to."""

    runtime: RuntimeState
    instructions: tuple[str, ...]
    seed: int
    randomization: RandomizationSample | None = None
    """What domain randomization has made of the scene."""


class TaskEnvironment:
    """The loop of one task: `reset`, `step`, `get_demos`.

    Args:
        runtime: The running scene, as it was built.
        action_mode: What actions mean.
        obs_config: What observations contain.
        seeds: Source of the seeds of episodes that are not given one.
        dataset_root: Folder of stored demonstrations.
        static_positions: Leave the task where its scene file puts it.
        shaped_rewards: Return the task's own reward.
        randomizer: Changes looks and physics, or None.
    """

    def __init__(
        self,
        runtime: Runtime,
        action_mode: ActionMode,
        obs_config: ObservationConfig,
        seeds: np.random.Generator,
        dataset_root: str = "",
        static_positions: bool = False,
        shaped_rewards: bool = False,
        randomizer: Randomizer | None = None,
    ) -> None:
        self._runtime, self._action_mode, self._obs_config = runtime, action_mode, obs_config
        self._seeds, self._dataset_root = seeds, dataset_root
        self._static_positions, self._shaped_rewards = static_positions, shaped_rewards
        self._randomizer = randomizer
        runtime.world.end_building()
        self._variation_number = 0
        self._instructions: tuple[str, ...] = ()
        self._seed = 0
        self._reset_attempts = 0
        self._reset_called = False
        self._succeeded = False

    # What it is -------------------------------------------------------------------------------------------------

    @property
    def world(self) -> World:
        """The simulated world."""
        return self._runtime.world

    @property
    def task(self) -> Task:
        """The running task."""
        return self._runtime.task

    @property
    def runtime(self) -> Runtime:
        """World, task and planner together, as action modes see them."""
        return self._runtime

    @property
    def action_mode(self) -> ActionMode:
        """What actions mean."""
        return self._action_mode

    @property
    def seed(self) -> int:
        """Seed of the present episode."""
        return self._seed

    @property
    def succeeded(self) -> bool:
        """Whether the goal was reached by the last step; False after a reset."""
        return self._succeeded

    def get_name(self) -> str:
        """Return the snake-case task name."""
        return self.task.get_name()

    def variation_count(self) -> int:
        """Return how many variations the task has."""
        return self.task.variation_count()

    def sample_variation(self) -> int:
        """Draw, set and return a variation."""
        self._variation_number = int(self._seeds.integers(self.variation_count()))
        return self._variation_number

    def set_variation(self, v: int) -> None:
        """Choose the variation of the next episodes; -1 draws one for each.

        Raises:
            TaskEnvironmentError: The task has no such variation.
        """
        count = self.variation_count()
        if not ALL_VARIATIONS <= v < count:
            raise TaskEnvironmentError(
                f"Task '{self.get_name()}' has no variation {v}: choose 0 to {count - 1}, or -1 to draw one for each episode."
            )
        self._variation_number = int(v)

    def get_task_descriptions(self) -> list[str]:
        """Return the instructions of the present episode."""
        self._need_reset("get_task_descriptions")
        return list(self._instructions)

    # The loop ---------------------------------------------------------------------------------------------------

    def reset(
        self, demo: Demo | None = None, *, seed: int | None = None, variation: int | None = None
    ) -> tuple[list[str], Observation]:
        """Start an episode.

        Args:
            demo: Start as this demonstration did; excludes the other arguments.
            seed: Seed of the episode; drawn from the environment's generator when None.
            variation: Sets the variation first.

        Returns:
            Instructions and the first observation.

        Raises:
            ResetError: The task could not be placed.
        """
        if demo is not None:
            return self.reset_to_demo(demo)
        if variation is not None:
            self.set_variation(variation)
        seed = int(self._seeds.integers(2**31)) if seed is None else _checked_seed(seed)
        self._start(seed, 0)
        return list(self._instructions), self.get_observation()

    def _start(self, seed: int, attempt: int) -> None:
        self._reset_called = self._succeeded = False
        random = EpisodeRandom.from_seed(seed, attempt)
        variation = self._variation_number
        if variation == ALL_VARIATIONS:
            variation = int(random.variation.integers(self.variation_count()))
        if self._randomizer is not None:
            self._randomizer.remove()
        start = start_episode(self._runtime, variation, random, static=self._static_positions)
        if self._randomizer is not None:
            self._randomizer.begin_episode(variation, random.randomization)
        self._instructions, self._reset_attempts, self._seed = start.instructions, start.attempts, seed
        self._reset_called = True

    def step(self, action: object) -> tuple[Observation, float, bool]:
        """Run one action.

        Returns:
            Observation, reward, and whether the episode has ended. Nothing resets by itself.

        Raises:
            NotReset: Before the first reset.
            InvalidActionError: The action was refused; the world is as it was.
        """
        self._need_reset("step")
        self._action_mode.action(self._runtime, action)
        success, terminate = self.task.success()
        self._succeeded = bool(success)
        return self.get_observation(), self._reward(success), bool(terminate)

    def _reward(self, success: bool) -> float:
        if not self._shaped_rewards:
            return float(success)
        reward = self.task.reward()
        if reward is None:
            raise TaskEnvironmentError(
                f"Task '{self.get_name()}' has no shaped reward. Use shaped_rewards=False, or give the task a `reward()`."
            )
        return float(reward)

    def action_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        return self._action_mode.action_bounds(self._runtime)

    def get_observation(self) -> Observation:
        """Observe without stepping."""
        self._need_reset("get_observation")
        return self._runtime.get_observation()

    def get_state(self) -> EnvironmentState:
        """Return the present moment; valid while this environment lives."""
        self._need_reset("get_state")
        randomization = None if self._randomizer is None else self._randomizer.current
        return EnvironmentState(self._runtime.save(), self._instructions, self._seed, randomization)

    def set_state(self, state: EnvironmentState) -> Observation:
        """Go back to a moment from `get_state` and observe it."""
        if self._randomizer is not None:
            self._randomizer.remove()
        self._runtime.restore(state.runtime)
        if self._randomizer is not None:
            self._randomizer.apply(state.randomization)
        self._instructions, self._seed, self._reset_called = state.instructions, state.seed, True
        return self.get_observation()

    # Demonstrations ---------------------------------------------------------------------------------------------

    def get_demos(
        self,
        amount: int,
        live_demos: bool = False,
        image_paths: bool = False,
        callable_each_step: Callable[[Observation], None] | None = None,
        max_attempts: int = MAX_DEMO_ATTEMPTS,
        random_selection: bool = True,
        from_episode_number: int = 0,
        *,
        seed: int | None = None,
    ) -> list[Demo]:
        """Return demonstrations of the present variation, stored or made now.

        Args:
            amount: How many; -1 is all stored ones.
            live_demos: Plan them now; otherwise read them from the dataset root.
            image_paths: Leave pictures unread (stored demonstrations).
            callable_each_step: Called with every recorded observation.
            max_attempts: Tries per live demonstration.
            random_selection: Pick stored demonstrations at random.
            from_episode_number: First stored episode when not picked at random.
            seed: Live demonstration i starts from `seed + i`; a retry is a further attempt of the same seed.

        Raises:
            DemoError: A live demonstration failed `max_attempts` times (also a RuntimeError).
            DatasetError: Stored demonstrations are missing or broken.
        """
        if not live_demos:
            return read_stored_demos(
                self._dataset_root,
                self.get_name(),
                amount,
                self._variation_number,
                self._obs_config,
                image_paths=image_paths,
                random_selection=random_selection,
                from_episode_number=from_episode_number,
                rng=self._seeds,
            )
        if amount < 1:
            raise TaskEnvironmentError(f"Live demonstrations need an amount of at least 1, not {amount}.")
        seeds = self._seeds.integers(2**31, size=amount) if seed is None else range(_checked_seed(seed), seed + amount)
        return [self._live_demo(int(s), max_attempts, callable_each_step) for s in seeds]

    def _live_demo(self, seed: int, max_attempts: int, on_frame: Callable[[Observation], None] | None) -> Demo:
        causes: list[str] = []
        for attempt in range(max_attempts):
            outcome = self.try_demo(seed=seed, attempt=attempt, on_frame=on_frame)
            if outcome.demo is not None:
                return outcome.demo
            causes.append(outcome.cause)
        raise LiveDemoFailed(self.get_name(), seed, causes, self.task)

    def try_demo(
        self,
        *,
        seed: int,
        variation: int | None = None,
        attempt: int = 0,
        on_frame: Callable[[Observation], None] | None = None,
        record: bool = True,
    ) -> DemoOutcome:
        """Reset with (seed, attempt) and play the demonstration once, whatever comes of it.

        Args:
            seed: Seed of the episode.
            variation: Sets the variation first.
            attempt: Which try of the seed.
            on_frame: Called with every recorded observation.
            record: Keep observations; False only measures.
        """
        if variation is not None:
            self.set_variation(variation)
        self._start(_checked_seed(seed), attempt)
        state = self.world.arrays(exact=False)
        began = self.world.time
        player = DemoPlayer(
            self._runtime, record=record, record_gripper=self._obs_config.record_gripper_closing, on_frame=on_frame
        )
        cause, leg = try_play(player)
        demo = None if cause else self._as_demo(player.frames, seed, attempt, state)
        duration = self.world.time - began
        return DemoOutcome(not cause, cause, leg, demo, player.planning_time, duration, tuple(player.legs))

    def _as_demo(self, frames: list[Observation], seed: int, attempt: int, state: dict[str, np.ndarray]) -> Demo:
        return Demo(
            frames,
            random_seed=seed,
            num_reset_attempts=self._reset_attempts,
            variation_number=self._runtime.variation,
            instructions=self._instructions,
            state=state,
            versions=library_versions(),
            attempt=attempt,
            task_name=self.get_name(),
        )

    def reset_to_demo(self, demo: Demo) -> tuple[list[str], Observation]:
        """Start as a demonstration did: its seed sets up the task, its snapshot the very state.

        Raises:
            TaskEnvironmentError: The demonstration is of another task or carries no seed.
        """
        if demo.task_name and demo.task_name != self.get_name():
            raise TaskEnvironmentError(f"The demonstration shows '{demo.task_name}', this is '{self.get_name()}'.")
        if demo.random_seed is None:
            raise TaskEnvironmentError("The demonstration carries no seed, so its start cannot be restored. Record it anew.")
        self.set_variation(demo.variation_number)
        self._start(demo.random_seed, demo.attempt)
        if demo.state is not None and not _same_arrays(self.world.arrays(exact=False), demo.state):
            self.world.set_arrays(demo.state)
            self.task.reset_conditions()
        return list(self._instructions), self.get_observation()

    def _need_reset(self, call: str) -> None:
        if not self._reset_called:
            raise NotReset(call)


class LiveDemoFailed(DemoError, RuntimeError):
    """A live demonstration failed at every attempt; carries why."""

    def __init__(self, task_name: str, seed: int, causes: list[str], task: object) -> None:
        self.seed, self.causes = seed, tuple(causes)
        text = "; ".join(f"attempt {i}: {cause}" for i, cause in enumerate(causes))
        super().__init__(
            f"Task '{task_name}' could not be demonstrated from seed {seed} in {len(causes)} attempts ({text}). "
            f"`rlbench-pin check {task_name}` shows how often that happens.",
            task,
        )


def library_versions() -> dict[str, str]:
    """Return name -> version of this package and the libraries that shape a demonstration."""
    return {name: _version(name) for name in _LIBRARIES}


def _version(name: str) -> str:
    try:
        return version(name.replace("_", "-"))
    except Exception:  # a source tree without metadata
        return "unknown"


def _checked_seed(seed: Any) -> int:
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise TaskEnvironmentError(f"A seed is a whole number >= 0, not {seed!r}.")
    return int(seed)


def _same_arrays(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[k], b[k]) for k in a)


__all__ = ["ALL_VARIATIONS", "EnvironmentState", "LiveDemoFailed", "TaskEnvironment", "library_versions"]
