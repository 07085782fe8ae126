"""Domain randomization of a runtime: draws a sample at the selected events, applies it and removes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.observations.observe import Appearance
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.randomization.sample import RandomizationSample, sample_appearance, sample_dynamics
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.sim import read_texture

if TYPE_CHECKING:
    from rlbench_pin.environment.episode import EpisodeRandom
    from rlbench_pin.environment.reset import Accept


class WorldChanges:
    """Applies samples to the world of a runtime, and removes them.

    Args:
        runtime: Runtime of the world.

    Attributes:
        current: The applied sample, or None.
        accept: Predicate that accepts or rejects the pose of the task; None accepts all.
    """

    accept: Accept | None = None

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self.current: RandomizationSample | None = None

    def prepare_episode(self, variation: int, seed: int, attempt: int) -> None:
        """Build the original world, before the objects of an episode are placed."""
        self.remove()
        self._runtime.build_again()

    def begin_episode(self, variation: int, random: EpisodeRandom, seed: int, attempt: int) -> None:
        """Change the world at the start of an episode.

        Args:
            variation: Variation of the task.
            random: Generators of the episode.
            seed: Seed of the episode.
            attempt: Number of the attempt at the seed, from 0.
        """
        raise NotImplementedError

    def apply(self, sample: RandomizationSample | None) -> None:
        """Apply a sample to the world; None restores the original world."""
        self._clear()
        self.current = sample
        self._runtime.place_arm(None if sample is None else sample.base)
        if sample is None:
            return
        self._runtime.observer.appearance = Appearance(
            sample.lighting, sample.cameras, sample.fields_of_view, sample.images, sample.joint_sigma
        )
        self._apply_textures(sample)
        world = self._runtime.world
        for name, (mass, friction, damping) in sample.dynamics.items():
            if name in world.bodies or name in world.room:
                world.dynamics_overrides.scale(world.body(name).model, mass=mass, friction=friction, damping=damping)
        world.dynamics_overrides.scale_gains(sample.gains)
        world.delay_commands(sample.latency, sample.loss, sample.loss_seed)

    def _apply_textures(self, sample: RandomizationSample) -> None:
        world = self._runtime.world
        for name, (path, repeats) in sample.bodies.items():
            if name in world.bodies:
                world.texture_overrides.set_body(name, read_texture(path), repeats)
        for link, (path, repeats) in sample.links.items():
            world.texture_overrides.set_robot_link(link, read_texture(path), repeats)
        for name, path in sample.room.items():
            world.texture_overrides.set_room_body(name, read_texture(path))
        for name, surface in sample.surfaces.items():
            if name in world.room:
                world.texture_overrides.shade_room_body(name, surface.pattern(), surface.tint)
            elif name in world.bodies:
                world.texture_overrides.shade_body(name, surface.shading(), surface.repeats)

    def remove(self) -> None:
        """Restore the original world, and keep the present sample in `current`."""
        self._clear()
        self._runtime.place_arm()

    def _clear(self) -> None:
        """Undo all changes except the base pose of the arm."""
        world = self._runtime.world
        world.texture_overrides.clear()
        world.dynamics_overrides.clear()
        world.delay_commands()
        self._runtime.observer.appearance = Appearance()


class Randomizer(WorldChanges):
    """Changes the appearance and the physics of one world at the selected events.

    Args:
        runtime: Runtime of the world.
        config: Settings of its cameras and lights.
        every: The event.
        frequency: Draw a new sample at the first event and at every `frequency`-th event after it.
        visual: Settings of the appearance, or None.
        dynamics: Settings of the physics, or None.
    """

    def __init__(
        self,
        runtime: Runtime,
        config: ObservationConfig,
        every: RandomizeEvery,
        frequency: int,
        visual: VisualRandomizationConfig | None,
        dynamics: DynamicsRandomizationConfig | None,
    ) -> None:
        super().__init__(runtime)
        self._config, self._every, self._frequency = config, every, frequency
        self._visual, self._dynamics = visual, dynamics
        self._events, self._last_variation = 0, -1
        self._rng = np.random.default_rng(0)
        if every is RandomizeEvery.TRANSITION:
            runtime.after_tick.append(self._event)

    def begin_episode(self, variation: int, random: EpisodeRandom, seed: int, attempt: int) -> None:
        """Randomize an episode after its setup, if this is an event."""
        self.randomize(variation, random.randomization)

    def randomize(self, variation: int, rng: np.random.Generator) -> None:
        """Randomize an episode of a variation after its setup, if this is an event; `rng` draws the samples."""
        self._rng = rng
        if self._every is RandomizeEvery.TRANSITION:
            self._events, self.current = 0, None
            return
        is_event = self._every is RandomizeEvery.EPISODE or variation != self._last_variation
        self._last_variation = variation
        if is_event:
            self._event()
        elif self.current is not None:
            self.apply(self.current)

    def _event(self) -> None:
        if self._events % self._frequency == 0:
            self.apply(self.sample(self._rng))
        elif self.current is not None and self._every is not RandomizeEvery.TRANSITION:
            self.apply(self.current)
        self._events += 1

    def sample(self, rng: np.random.Generator) -> RandomizationSample:
        """Draw a sample."""
        appearance = {} if self._visual is None else sample_appearance(self._runtime, self._config, self._visual, rng)
        dynamics = {} if self._dynamics is None else sample_dynamics(self._runtime, self._dynamics, rng)
        return RandomizationSample(**appearance, **dynamics)
