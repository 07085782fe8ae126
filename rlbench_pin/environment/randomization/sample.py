"""Samples of domain randomization: all differences to the original world."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, VisualRandomizationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import ImageNoise, Light, Lighting, Texture, shaded_texture
from rlbench_pin.spatial import FloatArray, matrix_to_pose


@dataclass(frozen=True)
class Surface:
    """Factor of the colours of an object, or of a part of the room."""

    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Factor of red, green and blue."""
    image: Path | None = None
    """Image of a pattern, or None."""
    share: float = 0.0
    """Fraction of the pattern, over its mean brightness; the rest is plain."""
    repeats: float = 1.0
    """Repetitions of the pattern per metre."""

    def pattern(self) -> Texture | None:
        """Return the pattern without tint; None without an image."""
        return None if self.image is None else shaded_texture(self.image, self.share, (1.0, 1.0, 1.0))

    def shading(self) -> Texture:
        """Return the pattern with its tint."""
        return shaded_texture(self.image, self.share, self.tint)


@dataclass(frozen=True, eq=False)
class RandomizationSample:
    """Drawn values of domain randomization, by name of body, camera or part of the room."""

    bodies: dict[str, tuple[Path, float]] = field(default_factory=dict)
    """Texture of each body, and its repetitions per metre."""
    links: dict[int, tuple[Path, float]] = field(default_factory=dict)
    """Texture of each link of the robot, by index, and its repetitions per metre."""
    room: dict[str, Path] = field(default_factory=dict)
    """Texture of each part of the room."""
    lighting: Lighting | None = None
    """Lights, or None for the lights in the settings."""
    cameras: dict[str, FloatArray] = field(default_factory=dict)
    """Pose (7,) of each moved camera in its original frame."""
    dynamics: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Factors of mass, friction and damping of each body."""
    gains: float = 1.0
    """Factor of the gains of the arm motors."""
    surfaces: dict[str, Surface] = field(default_factory=dict)
    """Patterns and tints over the original colours of bodies and parts of the room."""
    fields_of_view: dict[str, float] = field(default_factory=dict)
    """Factor of the field of view of each camera."""
    images: ImageNoise = ImageNoise()
    """Faults of the images."""
    joint_sigma: float = 0.0
    """Standard deviation of measured joint positions [rad]."""
    distractors: int = 0
    """Number of distractor objects at the start."""
    distractor_seed: int = 0
    """Seed of these objects and their positions."""
    start: FloatArray | None = None
    """Offsets of the joints at the start (n,) [rad]."""
    base: FloatArray | None = None
    """World pose (7,) of the arm base, or None for the pose in its description."""
    sizes: dict[str, float] = field(default_factory=dict)
    """Scale factor of each resized body."""
    models: dict[str, str] = field(default_factory=dict)
    """URDF file of each replaced body."""
    latency: int = 0
    """Delay of commands to the arm motors, in control ticks."""
    loss: float = 0.0
    """Probability that a command to the arm motors is lost."""
    loss_seed: int = 0
    """Seed of the losses."""
    instructions: tuple[str, ...] | None = None
    """Instructions instead of those of the task."""


def sample_appearance(
    runtime: Runtime, settings: ObservationConfig, config: VisualRandomizationConfig, rng: np.random.Generator
) -> dict[str, Any]:
    """Draw textures, lights and camera motions, as fields of a `RandomizationSample`.

    Args:
        runtime: Runtime of the world.
        settings: Lights and additional cameras.
        config: Settings of the appearance.
        rng: Generator of the draws.
    """
    world = runtime.world
    robot = config.randomize_arm and config.should_randomize(runtime.description.name)
    bodies = [name for name in world.bodies if config.should_randomize(name)] if config.textures else []
    links = world.texture_overrides.robot_links if config.textures and robot else ()
    room = [name for name in world.room if config.should_randomize(name)] if config.textures else []
    paths = iter(config.sample(len(bodies) + len(links) + len(room), rng))
    repeats = iter(rng.uniform(3.0, 10.0, len(bodies) + len(links)).tolist())
    cameras = (*CAMERAS, *settings.extra_cameras) if config.camera_shift or config.camera_turn else ()
    return {
        "bodies": {name: (next(paths), next(repeats)) for name in bodies},
        "links": {link: (next(paths), next(repeats)) for link in links},
        "room": {name: next(paths) for name in room},
        "lighting": _other_lighting(settings.lighting, config.light, rng) if config.light > 0.0 else None,
        "cameras": {name: _jitter(config.camera_shift, config.camera_turn, rng) for name in cameras},
    }


def sample_dynamics(runtime: Runtime, config: DynamicsRandomizationConfig, rng: np.random.Generator) -> dict[str, Any]:
    """Draw factors of physical properties, as fields of a `RandomizationSample`.

    Args:
        runtime: Runtime of the world.
        config: Settings of the physics.
        rng: Generator of the draws.
    """
    world = runtime.world
    names = [name for name in (*world.bodies, "table") if config.should_randomize(name)]
    ranges = (config.mass, config.friction, config.damping)
    factors = {name: tuple(float(rng.uniform(*bounds)) for bounds in ranges) for name in names}
    arm = config.randomize_arm and config.should_randomize(runtime.description.name)
    return {"dynamics": factors, "gains": float(rng.uniform(*config.gains)) if arm else 1.0}


def _other_lighting(lighting: Lighting, strength: float, rng: np.random.Generator) -> Lighting:
    """Return lights with other directions, another brightness and a tint."""
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
    angles = rng.normal(0.0, turn, 3)
    return small_motion(rng.normal(0.0, shift, 3), angles)


def small_motion(shift: FloatArray, angles: FloatArray) -> FloatArray:
    """Return a shift (3,) [m] and small angles (3,) about the axes [rad] as a pose (7,)."""
    x, y, z = angles
    matrix = np.eye(4)
    matrix[:3, 3] = shift
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    u, _, vt = np.linalg.svd(np.eye(3) + cross)
    matrix[:3, :3] = u @ vt
    return matrix_to_pose(matrix)
