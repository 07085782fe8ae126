"""Domain randomisation of a running scene: draw a disguise, put it on, take it off."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import Light, Lighting, read_texture
from rlbench_pin.spatial import FloatArray, matrix_to_pose


@dataclass(frozen=True, eq=False)
class Disguise:
    """Everything that differs from the scene as it was built."""

    bodies: dict[str, tuple[Path, float]] = field(default_factory=dict)
    """Texture of each body, and how often it repeats along a metre."""
    links: dict[int, tuple[Path, float]] = field(default_factory=dict)
    """The same for the links of the robot, by number."""
    room: dict[str, Path] = field(default_factory=dict)
    lighting: Lighting | None = None
    cameras: dict[str, FloatArray] = field(default_factory=dict)
    """Pose (7,) of each moved camera in its own frame."""
    factors: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Factors of mass, friction and damping of each body."""
    gains: float = 1.0


class Randomizer:
    """Changes looks and physics of one scene at the chosen events.

    Args:
        runtime: The running scene.
        config: Settings of its cameras and lights.
        every: The event.
        frequency: Every how manyth of them counts; the first always does.
        visual: What may change of the looks, or None.
        dynamics: What may change of the physics, or None.
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
        self._runtime, self._config, self._every, self._frequency = runtime, config, every, frequency
        self._visual, self._dynamics = visual, dynamics
        self._events, self._last_variation = 0, -1
        self._rng = np.random.default_rng(0)
        self.disguise: Disguise | None = None
        if every is RandomizeEvery.TRANSITION:
            runtime.register_step_callback(self._transition)

    # Events ----------------------------------------------------------------------------------------------------------

    def begin_episode(self, variation: int, rng: np.random.Generator) -> None:
        """Tell that an episode was set up; it has its own generator."""
        self._rng = rng
        if self._every is RandomizeEvery.TRANSITION:
            self._events, self.disguise = 0, None
            return
        is_event = self._every is RandomizeEvery.EPISODE or variation != self._last_variation
        self._last_variation = variation
        if is_event:
            self._event()
        elif self.disguise is not None:
            self.put_on(self.disguise)

    def _transition(self) -> None:
        if self._rng is not None:
            self._event()

    def _event(self) -> None:
        if self._events % self._frequency == 0:
            self.put_on(self.draw(self._rng))
        elif self.disguise is not None and self._every is not RandomizeEvery.TRANSITION:
            self.put_on(self.disguise)
        self._events += 1

    # Disguises -------------------------------------------------------------------------------------------------------

    def put_on(self, disguise: Disguise | None) -> None:
        """Make the scene look and behave as `disguise` says; None is the scene as it was built."""
        self.take_off()
        self.disguise = disguise
        if disguise is None:
            return
        world, look = self._runtime.world, self._runtime.observer.look
        for name, (path, repeats) in disguise.bodies.items():
            if name in world.bodies:
                world.texture_overrides.set_body(name, read_texture(path), repeats)
        for link, (path, repeats) in disguise.links.items():
            world.texture_overrides.set_robot_link(link, read_texture(path), repeats)
        for name, path in disguise.room.items():
            world.texture_overrides.set_room_body(name, read_texture(path))
        look.lighting, look.offsets = disguise.lighting, dict(disguise.cameras)
        for name, (mass, friction, damping) in disguise.factors.items():
            if name in world.bodies or name in world.room:
                world.dynamics_overrides.scale(world.body(name).model, mass=mass, friction=friction, damping=damping)
        world.dynamics_overrides.scale_gains(disguise.gains)

    def take_off(self) -> None:
        """Bring back the scene as it was built; the disguise is remembered."""
        world, look = self._runtime.world, self._runtime.observer.look
        world.texture_overrides.clear()
        world.dynamics_overrides.clear()
        look.lighting, look.offsets = None, {}

    def draw(self, rng: np.random.Generator) -> Disguise:
        """Draw a disguise."""
        looks = {} if self._visual is None else self._draw_looks(self._visual, rng)
        physics = {} if self._dynamics is None else self._draw_physics(self._dynamics, rng)
        return Disguise(**looks, **physics)

    def _draw_looks(self, config: VisualRandomizationConfig, rng: np.random.Generator) -> dict:
        world = self._runtime.world
        robot = config.randomize_arm and config.should_randomize(self._runtime.description.name)
        bodies = [name for name in world.bodies if config.should_randomize(name)] if config.textures else []
        links = world.texture_overrides.robot_links if config.textures and robot else ()
        room = [name for name in world.room if config.should_randomize(name)] if config.textures else []
        paths = iter(config.sample(len(bodies) + len(links) + len(room), rng))
        repeats = iter(rng.uniform(3.0, 10.0, len(bodies) + len(links)).tolist())
        cameras = (*CAMERAS, *self._config.extra_cameras) if config.camera_shift or config.camera_turn else ()
        return {
            "bodies": {name: (next(paths), next(repeats)) for name in bodies},
            "links": {link: (next(paths), next(repeats)) for link in links},
            "room": {name: next(paths) for name in room},
            "lighting": _other_lighting(self._config.lighting, config.light, rng) if config.light > 0.0 else None,
            "cameras": {name: _jitter(config.camera_shift, config.camera_turn, rng) for name in cameras},
        }

    def _draw_physics(self, config: DynamicsRandomizationConfig, rng: np.random.Generator) -> dict:
        world = self._runtime.world
        names = [name for name in (*world.bodies, "table") if config.should_randomize(name)]
        ranges = (config.mass, config.friction, config.damping)
        factors = {name: tuple(float(rng.uniform(*bounds)) for bounds in ranges) for name in names}
        arm = config.randomize_arm and config.should_randomize(self._runtime.description.name)
        return {"factors": factors, "gains": float(rng.uniform(*config.gains)) if arm else 1.0}


def _other_lighting(lighting: Lighting, strength: float, rng: np.random.Generator) -> Lighting:
    """Lights from elsewhere, brighter or dimmer, with a tint."""
    lights = [_other_light(light, strength, rng) for light in (lighting.key, *lighting.fills)]
    ambient = float(np.clip(lighting.ambient * (1.0 + strength * rng.uniform(-0.25, 0.15)), 0.2, 1.0))
    return Lighting(lights[0], tuple(lights[1:]), ambient)


def _other_light(light: Light, strength: float, rng: np.random.Generator) -> Light:
    direction = light.unit + strength * rng.uniform(-0.5, 0.5, 3)
    direction[2] = max(direction[2], 0.3)
    intensity = light.intensity * (1.0 + strength * rng.uniform(-0.4, 0.3))
    color = 1.0 - min(strength, 1.0) * rng.uniform(0.0, 0.3, 3)
    x, y, z = direction.tolist()
    red, green, blue = color.tolist()
    return Light((x, y, z), max(float(intensity), 0.0), (red, green, blue))


def _jitter(shift: float, turn: float, rng: np.random.Generator) -> FloatArray:
    """A small motion, as a pose (7,)."""
    x, y, z = rng.normal(0.0, turn, 3)
    matrix = np.eye(4)
    matrix[:3, 3] = rng.normal(0.0, shift, 3)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    u, _, vt = np.linalg.svd(np.eye(3) + cross)
    matrix[:3, :3] = u @ vt
    return matrix_to_pose(matrix)
