"""Draws of the factors for one episode, into a `RandomizationSample`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from rlbench_pin.assets import asset_path
from rlbench_pin.environment.episode import EpisodeRandom
from rlbench_pin.environment.factors.catalogue import FactorSetting, Numbers, factor_catalogue
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.randomization.config import images_in
from rlbench_pin.environment.randomization.sample import RandomizationSample, Surface, small_motion
from rlbench_pin.environment.reset import MAX_RESET_ATTEMPTS, Accept, lay_out
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import BoundaryError, TaskEnvironmentError
from rlbench_pin.observation import CAMERAS
from rlbench_pin.scene.spec import WORLD
from rlbench_pin.sim import Light, Lighting, World
from rlbench_pin.spatial import IDENTITY, compose, pose_at, pose_to_se3
from rlbench_pin.tasks.placement import footprint
from rlbench_pin.tasks.task import Wording

REPEATS = (4.0, 8.0)
"""Repetitions of patterns on objects per metre."""
DRAWN_SEEDS = 2**31
"""Number of seeds to draw from."""
OTHER = "instruction_other"
"""The factor whose instructions are drawn by `other_instructions`."""
FIRST = ("arm_base", "object_model", "object_size", "receiver_size")
"""The factors that apply before the objects of the episode are placed."""
SIZE_STEP = 0.02
"""Step of scale factors: sizes are multiples of it, to limit the number of shapes in memory."""


@dataclass(frozen=True)
class Draw:
    """Sources of the draws of one factor in one episode."""

    runtime: Runtime
    """The running task, at the start of the episode."""
    settings: ObservationConfig
    """Lights and cameras without factors."""
    rng: np.random.Generator
    """Generator of this factor and episode, the same at every level."""
    numbers: Numbers
    """Numbers of the level."""

    def number(self, name: str) -> float:
        """Draw a value from a range of the level; return a single value unchanged."""
        value = self.numbers[name]
        return float(self.rng.uniform(*value)) if isinstance(value, tuple) else float(value)

    def either_side(self, name: str) -> float:
        """Draw a value of the level, and its sign."""
        sign = 1.0 if self.rng.random() < 0.5 else -1.0
        return sign * self.number(name)

    def channels(self) -> tuple[float, float, float]:
        """Draw a factor for red, green and blue."""
        red, green, blue = (self.number("channel") for _ in range(3))
        return red, green, blue

    def seed(self) -> int:
        """Draw a seed."""
        return int(self.rng.integers(DRAWN_SEEDS))

    def lighting(self, sample: RandomizationSample) -> Lighting:
        """Return the lights of the sample so far."""
        return sample.lighting or self.settings.lighting


Sample = RandomizationSample
DrawFunction = Callable[[Draw, Sample], Sample]


def draw_factors(runtime: Runtime, settings: ObservationConfig, setting: FactorSetting, seed: int, attempt: int) -> Sample:
    """Draw all changes of a setting in one episode. Each factor has its own generator.

    Args:
        runtime: The running task, at the start of the episode.
        settings: Lights and cameras without factors.
        setting: The factors and their levels, without `combined`; `other_instructions` draws `instruction_other`.
        seed: Seed of the episode.
        attempt: Number of the attempt at the seed, from 0.
    """
    sample, catalogue = Sample(), factor_catalogue()
    for name, level in setting.levels:
        if name != OTHER:
            numbers = catalogue[name].numbers_for(level, runtime.task)
            draw = Draw(runtime, settings, factor_rng(name, seed, attempt), numbers)
            sample = FUNCTIONS[name](draw, sample)
    return sample


def factor_rng(name: str, seed: int, attempt: int) -> np.random.Generator:
    """Return the generator of a factor in one episode, independent of all others."""
    return np.random.default_rng(np.random.SeedSequence((seed, attempt), spawn_key=tuple(name.encode())))


# Appearance ----------------------------------------------------------------------------------------------------------


def _tinted(role: str) -> DrawFunction:
    def draw(draw: Draw, sample: Sample) -> Sample:
        names = draw.runtime.unpainted_bodies(role)
        return _with_surfaces(sample, {name: replace(_surface(sample, name), tint=draw.channels()) for name in names})

    return draw


def _patterned(role: str) -> DrawFunction:
    def draw(draw: Draw, sample: Sample) -> Sample:
        return _with_patterns(draw, sample, draw.runtime.unpainted_bodies(role))

    return draw


def _table_color(draw: Draw, sample: Sample) -> Sample:
    return _with_surfaces(sample, {"table": replace(_surface(sample, "table"), tint=draw.channels())})


def _table_texture(draw: Draw, sample: Sample) -> Sample:
    return _with_patterns(draw, sample, ["table"])


def _background_texture(draw: Draw, sample: Sample) -> Sample:
    return _with_patterns(draw, sample, [name for name in draw.runtime.world.room if name != "table"])


def _with_patterns(draw: Draw, sample: Sample, names: list[str]) -> Sample:
    images, changed = _patterns(), {}
    for name in names:
        image, repeats = images[int(draw.rng.integers(len(images)))], float(draw.rng.uniform(*REPEATS))
        changed[name] = replace(_surface(sample, name), image=image, share=draw.number("share"), repeats=repeats)
    return _with_surfaces(sample, changed)


@cache
def _patterns() -> tuple[Path, ...]:
    """Return the image files of the patterns."""
    return images_in(asset_path("textures"))


def _surface(sample: Sample, name: str) -> Surface:
    return sample.surfaces.get(name, Surface())


def _with_surfaces(sample: Sample, surfaces: Mapping[str, Surface]) -> Sample:
    return replace(sample, surfaces={**sample.surfaces, **surfaces})


def _light_color(draw: Draw, sample: Sample) -> Sample:
    tint = np.array(draw.channels())
    return _with_lights(draw, sample, lambda light: replace(light, color=_rgb(np.array(light.color) * tint)))


def _light_direction(draw: Draw, sample: Sample) -> Sample:
    angle = draw.either_side("angle")
    cos, sin = float(np.cos(angle)), float(np.sin(angle))
    lighting = draw.lighting(sample)
    x, y, z = lighting.key.direction
    key = replace(lighting.key, direction=(cos * x - sin * y, sin * x + cos * y, z))
    return replace(sample, lighting=replace(lighting, key=key))


def _light_intensity(draw: Draw, sample: Sample) -> Sample:
    factor = 2.0 ** draw.either_side("stops")
    sample = _with_lights(draw, sample, lambda light: replace(light, intensity=light.intensity * factor))
    lighting = draw.lighting(sample)
    return replace(sample, lighting=replace(lighting, ambient=min(lighting.ambient * factor, 1.0)))


def _shadow(draw: Draw, sample: Sample) -> Sample:
    lighting = draw.lighting(sample)
    moved = draw.number("share") * lighting.ambient
    key = replace(lighting.key, intensity=lighting.key.intensity + moved)
    return replace(sample, lighting=replace(lighting, key=key, ambient=lighting.ambient - moved))


def _with_lights(draw: Draw, sample: Sample, change: Callable[[Light], Light]) -> Sample:
    lighting = draw.lighting(sample)
    fills = tuple(change(light) for light in lighting.fills)
    return replace(sample, lighting=replace(lighting, key=change(lighting.key), fills=fills))


def _rgb(color: np.ndarray) -> tuple[float, float, float]:
    red, green, blue = color.tolist()
    return red, green, blue


def _camera_pose(draw: Draw, sample: Sample) -> Sample:
    poses = {}
    for name in _cameras(draw):
        shift = np.array([draw.either_side("shift") for _ in range(3)])
        poses[name] = small_motion(shift, np.array([draw.either_side("angle") for _ in range(3)]))
    return replace(sample, cameras=poses)


def _camera_fov(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, fields_of_view={name: 1.0 + draw.either_side("share") for name in _cameras(draw)})


def _table_height(draw: Draw, sample: Sample) -> Sample:
    shift, poses = draw.either_side("shift"), dict(sample.cameras)
    for name, camera in ((name, draw.runtime.cameras[name]) for name in _cameras(draw)):
        if camera.parent == WORLD:
            lowered = pose_to_se3(camera.pose).rotation.T @ np.array([0.0, 0.0, -shift])
            poses[name] = compose(pose_at(lowered), poses.get(name, IDENTITY))
    return replace(sample, cameras=poses)


def _cameras(draw: Draw) -> tuple[str, ...]:
    return (*CAMERAS, *draw.settings.extra_cameras)


# Sensors -------------------------------------------------------------------------------------------------------------


def _image_blur(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, images=replace(sample.images, blur=draw.number("sigma")))


def _image_jpeg(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, images=replace(sample.images, jpeg_quality=round(draw.number("quality"))))


def _image_exposure(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, images=replace(sample.images, exposure=draw.either_side("stops")))


def _dead_pixels(draw: Draw, sample: Sample) -> Sample:
    seed = draw.seed()
    return replace(sample, images=replace(sample.images, dead_share=draw.number("share"), seed=seed))


def _depth_noise(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, images=replace(sample.images, depth_sigma=draw.number("sigma")))


def _joint_noise(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, joint_sigma=draw.number("sigma"))


# Scene, physics and arm -----------------------------------------------------------------------------------------------


def _distractors(draw: Draw, sample: Sample) -> Sample:
    seed = draw.seed()
    return replace(sample, distractors=round(draw.number("count")), distractor_seed=seed)


def _sized(role: str) -> DrawFunction:
    def draw(draw: Draw, sample: Sample) -> Sample:
        factor = round(SIZE_STEP * round(draw.number("factor") / SIZE_STEP), 2)
        named = [body.name for body in draw.runtime.world.spec.body if body.role == role]
        return replace(sample, sizes={**sample.sizes, **dict.fromkeys(named, factor)})

    return draw


def _object_model(draw: Draw, sample: Sample) -> Sample:
    """Draw a look-alike for each kind of object; objects of one kind get the same."""
    bodies = [body for body in draw.runtime.world.spec.body if body.look_alikes]
    chosen = {kind: kind[int(draw.rng.integers(len(kind)))] for kind in dict.fromkeys(body.look_alikes for body in bodies)}
    models = {body.name: chosen[body.look_alikes] for body in bodies}
    return replace(sample, models=models)


def _unchanged(draw: Draw, sample: Sample) -> Sample:
    """Return the sample unchanged: these factors apply before the objects of the episode are placed."""
    return sample


def _on_the_left(world: World) -> bool:
    """Return whether the middle of the task's footprint is on the left of the arm, at y >= 0."""
    middle = np.append(np.mean(footprint(world), axis=0), 0.0)
    return bool(pose_to_se3(world.root.pose).act(middle)[1] >= 0.0)


PLACES: Mapping[str, Accept] = {
    "placement_left": _on_the_left,
    "placement_right": lambda world: not _on_the_left(world),
}
"""Factor -> predicate that accepts or rejects the pose of the task."""


def _scaled(place: int) -> DrawFunction:
    """Scale mass (0), friction (1) or damping (2) of each body, and the friction of the table."""

    def draw(draw: Draw, sample: Sample) -> Sample:
        names = (*draw.runtime.world.bodies, "table")
        return _with_dynamics(sample, place, {name: draw.number("factor") for name in names})

    return draw


def _mass(draw: Draw, sample: Sample) -> Sample:
    """Scale the mass of each body, or set the masses [kg] that the numbers give by name of the body."""
    if "factor" in draw.numbers:
        return _scaled(0)(draw, sample)
    world, factors = draw.runtime.world, {}
    for name in draw.numbers:
        model = world.body(name).model
        mass = sum(world.dynamics_overrides.mass(model, link) for link in model.links.values())
        factors[name] = draw.number(name) / mass
    return _with_dynamics(sample, 0, factors)


def _with_dynamics(sample: Sample, place: int, factors: Mapping[str, float]) -> Sample:
    """Return a sample with factors of mass (0), friction (1) or damping (2) by name of the body."""
    scales = dict(sample.dynamics)
    for name, factor in factors.items():
        numbers = list(scales.get(name, (1.0, 1.0, 1.0)))
        numbers[place] = factor
        mass, friction, damping = numbers
        scales[name] = (mass, friction, damping)
    return replace(sample, dynamics=scales)


def _arm_gains(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, gains=draw.number("factor"))


def _start_configuration(draw: Draw, sample: Sample) -> Sample:
    count = draw.runtime.model.size
    offsets = np.array([draw.either_side("angle") for _ in range(count)])
    return replace(sample, start=offsets)


def _arm_base(draw: Draw, sample: Sample) -> Sample:
    x, y, turn = draw.either_side("shift"), draw.either_side("shift"), draw.either_side("angle")
    return replace(sample, base=compose(draw.runtime.description.base_pose, pose_at((x, y, 0.0), yaw=turn)))


def _action_latency(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, latency=round(draw.number("ticks")))


def _action_loss(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, loss=draw.number("probability"), loss_seed=draw.seed())


# Language ------------------------------------------------------------------------------------------------------------


def _worded(kind: Wording) -> DrawFunction:
    def draw(draw: Draw, sample: Sample) -> Sample:
        sentences = draw.runtime.task.get_wording(kind)
        first = int(draw.rng.integers(len(sentences)))
        return replace(sample, instructions=(*sentences[first:], *sentences[:first]))

    return draw


def other_instructions(runtime: Runtime, variation: int, seed: int, attempt: int) -> tuple[str, ...]:
    """Return the instructions of another variation, drawn for an episode. The caller must place the objects again afterwards.

    Args:
        runtime: The running task.
        variation: Variation of the episode.
        seed: Seed of the episode.
        attempt: Number of the attempt at the seed, from 0.

    Raises:
        TaskEnvironmentError: All other variations share an instruction with this one.
    """
    rng = factor_rng(OTHER, seed, attempt)
    own = set(_sentences_of(runtime, variation, seed))
    for other in rng.permutation(runtime.task.variation_count()).tolist():
        if other != variation and not own & set(sentences := _sentences_of(runtime, other, seed)):
            return tuple(sentences)
    raise TaskEnvironmentError(
        f"All variations of '{runtime.task.get_name()}' share an instruction with variation {variation}, so '{OTHER}' has no "
        "other instruction for it. Choose another variation, or omit this factor."
    )


def _sentences_of(runtime: Runtime, variation: int, seed: int) -> list[str]:
    for attempt in range(MAX_RESET_ATTEMPTS):
        try:
            return lay_out(runtime, variation, EpisodeRandom.from_seed(seed, attempt), static=True)
        except BoundaryError:
            continue
    raise BoundaryError(f"variation {variation} has no valid placement in {MAX_RESET_ATTEMPTS} attempts")


def _no_instruction(draw: Draw, sample: Sample) -> Sample:
    return replace(sample, instructions=("",))


FUNCTIONS: Mapping[str, DrawFunction] = {
    "object_color": _tinted("manipulated"),
    "object_texture": _patterned("manipulated"),
    "receiver_color": _tinted("receiving"),
    "receiver_texture": _patterned("receiving"),
    "table_color": _table_color,
    "table_texture": _table_texture,
    "background_texture": _background_texture,
    "light_color": _light_color,
    "light_direction": _light_direction,
    "light_intensity": _light_intensity,
    "shadow": _shadow,
    "camera_pose": _camera_pose,
    "camera_fov": _camera_fov,
    "table_height": _table_height,
    "image_blur": _image_blur,
    "image_jpeg": _image_jpeg,
    "image_exposure": _image_exposure,
    "dead_pixels": _dead_pixels,
    "depth_noise": _depth_noise,
    "joint_noise": _joint_noise,
    "distractors": _distractors,
    "object_model": _object_model,
    "object_size": _sized("manipulated"),
    "receiver_size": _sized("receiving"),
    **dict.fromkeys(PLACES, _unchanged),
    "mass": _mass,
    "friction": _scaled(1),
    "damping": _scaled(2),
    "arm_gains": _arm_gains,
    "start_configuration": _start_configuration,
    "arm_base": _arm_base,
    "action_latency": _action_latency,
    "action_loss": _action_loss,
    "instruction_specific": _worded("specific"),
    "instruction_held_out": _worded("held_out"),
    "instruction_vague": _worded("vague"),
    "instruction_none": _no_instruction,
}
"""Factor -> function that draws its changes."""
