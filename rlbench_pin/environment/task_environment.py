"""`TaskEnvironment`: the environment of one task."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from threading import RLock
from typing import Any

import numpy as np

from rlbench_pin.datasets.layout import ALL_VARIATIONS
from rlbench_pin.environment import demos
from rlbench_pin.environment.actions.modes import ActionMode
from rlbench_pin.environment.demos import DemoOutcome, DemoPlayer
from rlbench_pin.environment.episode import MAX_DEMOS, EnvironmentState, EpisodeOrigin, EpisodeRandom, checked_seed, demo_seeds
from rlbench_pin.environment.factors import FactorRandomizer, FactorSetting, FactorsLike
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.randomization.randomizer import WorldChanges
from rlbench_pin.environment.recovery import DisturbedPlayer, as_disturbances
from rlbench_pin.environment.reset import start_episode
from rlbench_pin.environment.runtime import RefusedOpening, Runtime, success_is_stable
from rlbench_pin.environment.stored import StoredSelection, read_stored_demos
from rlbench_pin.errors import InvalidArgument, NotReset, TaskEnvironmentError, UsedByTwoThreads
from rlbench_pin.observation import Demo, Disturbance, Observation
from rlbench_pin.sim import World
from rlbench_pin.tasks import Task
from rlbench_pin.values import LARGEST_SEED, as_flag, as_function, as_record, as_whole, names_arguments

MAX_DEMO_ATTEMPTS = 10
"""Maximum number of attempts per live demonstration."""


class TaskEnvironment:
    """The environment of one task: `reset`, `step`, `get_demos`.

    Args:
        runtime: World, task and planner.
        action_mode: Meaning, size and bounds of an action.
        obs_config: Contents of observations.
        seeds: Generator of seeds for episodes that are not given a seed.
        dataset_root: Folder of stored demonstrations.
        static_positions: Keep the task at the pose of its scene file.
        shaped_rewards: Return the shaped reward of the task.
        changes: Changes of the appearance, physics and instructions of each episode, or None.
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
        changes: WorldChanges | None = None,
    ) -> None:
        self._runtime, self._action_mode, self._obs_config = runtime, action_mode, obs_config
        self._seeds, self._dataset_root = seeds, dataset_root
        self._static_positions, self._shaped_rewards = static_positions, shaped_rewards
        self._changes = changes
        runtime.world.end_building()
        self._variation_number, self._succeeded = 0, False
        self._refused_opening: RefusedOpening | None = None
        self._episode: EpisodeOrigin | None = None
        self._in_use = RLock()

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
        """World, task and planner: the interface for action modes."""
        return self._runtime

    @property
    def action_mode(self) -> ActionMode:
        """The action mode."""
        return self._action_mode

    @property
    def seed(self) -> int:
        """Seed of the present episode; 0 before the first reset."""
        return 0 if self._episode is None else self._episode.seed

    @property
    def episode(self) -> EpisodeOrigin:
        """Origin of the present episode.

        Raises:
            NotReset: Before the first reset.
        """
        return self._started("episode")

    @property
    def succeeded(self) -> bool:
        """Whether the goal was reached by the last step; False after a reset."""
        return self._succeeded

    @property
    def refused_opening(self) -> RefusedOpening | None:
        """The reason why `SafeArm` did not open the fingers in the last action; None if it did not prevent this."""
        return self._refused_opening

    def get_name(self) -> str:
        """Return the snake-case task name."""
        return self.task.get_name()

    def variation_count(self) -> int:
        """Return the number of variations of the task."""
        return self.task.variation_count()

    def sample_variation(self) -> int:
        """Draw, set and return a variation."""
        self._variation_number = int(self._seeds.integers(self.variation_count()))
        return self._variation_number

    def set_variation(self, v: int) -> None:
        """Set the variation of the next episodes; -1 draws one for each episode.

        Raises:
            TaskEnvironmentError: The task has no such variation, or it is not an integer.
        """
        count = self.variation_count()
        v = as_whole(v, f"A variation of '{self.get_name()}'", InvalidArgument)
        if not ALL_VARIATIONS <= v < count:
            raise TaskEnvironmentError(
                f"Task '{self.get_name()}' has no variation {v}. Choose 0 to {count - 1}, or -1 to draw one for each episode."
            )
        self._variation_number = v

    @property
    def factors(self) -> FactorSetting:
        """The factors of generalisation of the next episodes."""
        return self._changes.setting if isinstance(self._changes, FactorRandomizer) else FactorSetting()

    def set_factors(self, factors: FactorsLike) -> None:
        """Set the factors of the next episodes.

        Args:
            factors: For example `light_color:2+friction:1`, `{"light_color": 2}`, or `""` for none.

        Raises:
            UnknownName: There is no such factor.
            FactorNotApplicable: One of the factors does not apply to the task.
            InvalidArgument: A factor has no such level, or the environment has domain randomization.
        """
        setting = FactorSetting.of(factors)
        if setting == self.factors:
            return
        if self._changes is not None and not isinstance(self._changes, FactorRandomizer):
            hint = "Create an Environment without randomization, or select no factors."
            raise InvalidArgument("factors", str(setting), "cannot be combined with domain randomization", hint)
        changes = FactorRandomizer(self._runtime, self._obs_config, setting) if setting else None
        if self._changes is not None:
            self._changes.remove()
        self._changes = changes

    def get_task_descriptions(self) -> list[str]:
        """Return the instructions of the present episode."""
        return list(self._started("get_task_descriptions").instructions)

    # The loop ---------------------------------------------------------------------------------------------------

    def reset(
        self, demo: Demo | None = None, *, seed: int | None = None, variation: int | None = None
    ) -> tuple[list[str], Observation]:
        """Start an episode.

        Args:
            demo: Restore the start of this demonstration; excludes the other arguments.
            seed: Seed of the episode; None draws one from the generator of the environment.
            variation: Variation of this and the next episodes; None keeps the present setting.

        Returns:
            Instructions and the first observation.

        Raises:
            ResetError: The task could not be placed.
        """
        if demo is not None:
            return self.reset_to_demo(as_record(demo, Demo, "demo", InvalidArgument))
        if variation is not None:
            self.set_variation(variation)
        seed = int(self._seeds.integers(2**31)) if seed is None else checked_seed(seed)
        self._start(seed, 0)
        return self.get_task_descriptions(), self.get_observation()

    def _start(self, seed: int, attempt: int, variation: int | None = None) -> EpisodeOrigin:
        with self._alone("reset"):
            return self._begin(seed, attempt, variation)

    def _begin(self, seed: int, attempt: int, variation: int | None) -> EpisodeOrigin:
        self._episode, self._succeeded, self._refused_opening = None, False, None
        random = EpisodeRandom.from_seed(seed, attempt)
        variation = self._variation_number if variation is None else variation
        if variation == ALL_VARIATIONS:
            variation = int(random.variation.integers(self.variation_count()))
        changes = self._changes
        if changes is None:
            self._runtime.build_again()
        else:
            changes.prepare_episode(variation, seed, attempt)
        accept = None if changes is None else changes.accept
        start = start_episode(self._runtime, variation, random, static=self._static_positions, accept=accept)
        if changes is not None:
            changes.begin_episode(variation, random, seed, attempt)
        self._episode = EpisodeOrigin(seed, attempt, start.attempts, self._runtime.instructions, str(self.factors))
        return self._episode

    def step(self, action: object) -> tuple[Observation, float, bool]:
        """Execute one action. The action stops early if the episode ends during it.

        The episode ends at the first control tick at which the success conditions hold, or the conditions of the fail list. It is
        not reset automatically: call `reset` to start the next one.

        Args:
            action: Numbers of shape (n,), with the meaning, units and bounds that the action mode defines.

        Returns:
            Observation after the action, reward, and whether the episode has ended.

        Raises:
            NotReset: `reset` was never called.
            InvalidActionError: The action was refused; the world has not changed.
            NoShapedReward: Shaped rewards are on and the task has none (also a RuntimeError).
            UsedByTwoThreads: Another thread is in a call of this environment (also a RuntimeError).
        """
        self._started("step")
        with self._alone("step"):
            with self._runtime.acting() as result:
                self._action_mode.action(self._runtime, action)
            self._succeeded, self._refused_opening = result.success, result.refused_opening
            return self.get_observation(), result.reward(self._shaped_rewards), result.over

    def success_is_stable(self) -> bool:
        """Return whether success holds now and still holds after 1 s with arm and gripper stationary; restore the state."""
        self._started("success_is_stable")
        return success_is_stable(self._runtime)

    def action_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and highest values of an action, each of shape (n,)."""
        return self._action_mode.bounds(self._runtime)

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step."""
        self._started("get_observation")
        with self._alone("get_observation"):
            return self._runtime.get_observation()

    def get_state(self) -> EnvironmentState:
        """Return the present state for `set_state`; it can be pickled for another environment of the same task."""
        episode = self._started("get_state")
        randomization = None if self._changes is None else self._changes.current
        with self._alone("get_state"):
            return EnvironmentState(self._runtime.save(portable=True), episode, randomization)

    def set_state(self, state: EnvironmentState) -> Observation:
        """Restore a state from `get_state`, including its factors, and return the observation."""
        if not isinstance(state, EnvironmentState):
            raise InvalidArgument("state", state, "has to be a state from `get_state()`")
        self.set_factors(state.episode.factors)
        if state.runtime.build != self._runtime.build:  # a copy does not depend on its world, which is gone
            state = deepcopy(state)
        if (variation := state.unpickled_variation(self.get_name())) is not None:  # begun again, a task has the same objects
            self._start(state.episode.seed, state.episode.attempt, variation)
        with self._alone("set_state"):
            changes = None if self._changes is None or self._changes.current is state.randomization else self._changes
            if changes is not None:
                changes.remove()
            self._runtime.restore(state.runtime)
            if changes is not None:
                changes.apply(state.randomization)
            self._episode = state.episode
            return self.get_observation()

    # Demonstrations ---------------------------------------------------------------------------------------------

    @names_arguments
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
        disturb: Sequence[Disturbance] = (),
    ) -> list[Demo]:
        """Return demonstrations of the current variation: plan them now, or read stored ones.

        Args:
            amount: Number of demonstrations; -1 reads all stored ones.
            live_demos: True plans them now; False reads them from the dataset root.
            image_paths: Stored demonstrations: do not read images; fields contain strings instead.
            callable_each_step: Live demonstrations: function that is called with every recorded observation.
            max_attempts: Maximum number of attempts per live demonstration.
            random_selection: Stored demonstrations: draw them at random, without repeats.
            from_episode_number: Stored demonstrations: index of the first one without `random_selection`. With variation -1
                it counts through all variations.
            seed: Live demonstration i has the seed `seed + i`; all its attempts use the same seed. None draws seeds.
            disturb: Live demonstrations: apply one of these disturbances to each: `push`, `slip`, `stop`. Empty: none.

        Raises:
            DemoError: A live demonstration failed in all `max_attempts` attempts (also a RuntimeError).
            DatasetError: Stored demonstrations are missing or damaged.
        """
        if not as_flag(live_demos, "live_demos", InvalidArgument):
            wanted = StoredSelection(amount, self._variation_number, image_paths, random_selection, from_episode_number)
            return read_stored_demos(self._dataset_root, self.get_name(), wanted, self._obs_config, self._seeds)
        return demos.live_demos(
            lambda s, attempt: self.try_demo(seed=s, attempt=attempt, on_frame=callable_each_step, disturb=disturb),
            self.task,
            demo_seeds(amount, seed, self._seeds),
            as_whole(max_attempts, "max_attempts", InvalidArgument, least=1, most=MAX_DEMOS),
        )

    def try_demo(
        self,
        *,
        seed: int,
        variation: int | None = None,
        attempt: int = 0,
        on_frame: Callable[[Observation], None] | None = None,
        record: bool = True,
        disturb: Sequence[Disturbance] = (),
    ) -> DemoOutcome:
        """Reset with (seed, attempt), play the demonstration once, and return its result.

        Args:
            seed: Seed of the episode.
            variation: Variation of this and the next episodes; None keeps the present setting.
            attempt: Number of the attempt at the seed, from 0.
            on_frame: Function that is called with each recorded observation.
            record: Keep observations; False only measures.
            disturb: Disturbances, of which one is applied: `push`, `slip`, `stop`. The planner continues from the state after it.
        """
        if variation is not None:
            self.set_variation(variation)
        kinds = as_disturbances(disturb)
        episode = self._start(checked_seed(seed), as_whole(attempt, "attempt", InvalidArgument, least=0, most=LARGEST_SEED))
        as_function(on_frame, "on_frame", InvalidArgument)
        record = as_flag(record, "record", InvalidArgument)
        gripper = self._obs_config.record_gripper_closing
        with self._alone("try_demo"):
            options: dict[str, Any] = {"record": record, "record_gripper": gripper, "on_frame": on_frame}
            player = DemoPlayer(self._runtime, **options)
            if kinds:
                rng = EpisodeRandom.from_seed(episode.seed, episode.attempt).disturbance
                player = DisturbedPlayer(self._runtime, kinds, rng, **options)
            return demos.play_demo(episode, player)

    def reset_to_demo(self, demo: Demo) -> tuple[list[str], Observation]:
        """Restore the start of a demonstration from its seed, its factors and its snapshot.

        Raises:
            TaskEnvironmentError: The demonstration has another task or another arm, or contains no seed.
        """
        seed = demos.check_start(demo, self.get_name(), self._runtime.model.description.reference)
        self.set_variation(demo.variation_number)
        self.set_factors(demo.factors)
        self._start(seed, demo.attempt)
        demos.restore_start(self._runtime, demo)
        return self.get_task_descriptions(), self.get_observation()

    @contextmanager
    def _alone(self, call: str) -> Iterator[None]:
        """Reject a call while another thread is in a call; nested calls of the same thread are allowed."""
        if not self._in_use.acquire(blocking=False):
            raise UsedByTwoThreads(call)
        try:
            yield
        finally:
            self._in_use.release()

    def _started(self, call: str) -> EpisodeOrigin:
        if self._episode is None:
            raise NotReset(call)
        return self._episode
