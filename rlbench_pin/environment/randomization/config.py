"""Settings of domain randomization: its events and its ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from fnmatch import fnmatchcase
from pathlib import Path
from typing import ClassVar

import numpy as np

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import CameraError, InvalidValue, TaskEnvironmentError, shown
from rlbench_pin.values import FLAG, NOT_NEGATIVE, Rule, Settings, as_interval, as_names, as_path, is_whole, ruled

_IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")


class RandomizeEvery(Enum):
    """The event of a new randomization."""

    EPISODE = "episode"
    """Each reset."""
    VARIATION = "variation"
    """Each reset with another variation than the previous one."""
    TRANSITION = "transition"
    """Each control tick."""


class RandomizationMisused(TaskEnvironmentError, ValueError):
    """The arguments of randomization are invalid or contradict each other."""


class NoTextureFolder(CameraError, NotADirectoryError):
    """The folder of textures does not exist."""


class NoTextures(CameraError, RuntimeError):
    """The folder of textures has no images."""


def _as_folder(value: object) -> Path:
    try:
        return as_path(value, "image_directory")
    except InvalidValue as error:
        raise RandomizationMisused(str(error)) from error


def _as_patterns(value: object, what: str) -> object:
    if value is None:
        return None
    try:
        as_names(value, what)
    except InvalidValue as error:
        raise RandomizationMisused(str(error)) from error
    return value


def _as_factors(value: object, what: str) -> tuple[float, float]:
    try:
        low, high = as_interval(value, what)
    except InvalidValue as error:
        raise RandomizationMisused(f"{error} Factors are 0 < lowest <= highest.") from error
    if low <= 0.0:
        name = what.rpartition(".")[2]
        raise RandomizationMisused(f"The factors of {name} must be 0 < lowest <= highest, not ({low}, {high}).")
    return low, high


@dataclass
class RandomizationConfig(Settings):
    """Objects that may change, by the names of bodies, of parts of the room (`table`, `floor`, `wall_front`...) and the robot."""

    rules: ClassVar[Mapping[str, Rule]] = ruled((_as_patterns, "whitelist blacklist"), (FLAG, "randomize_arm"))

    whitelist: Sequence[str] | None = None
    """Only these objects change; `*` and `?` are wildcards. None: all objects."""
    blacklist: Sequence[str] | None = None
    """These objects do not change, even if they are in `whitelist`."""
    randomize_arm: bool = True
    """Randomize the robot."""

    def should_randomize(self, name: str) -> bool:
        """Return whether the object with this name may change."""
        if self.whitelist is not None and not any(fnmatchcase(name, pattern) for pattern in self.whitelist):
            return False
        return not any(fnmatchcase(name, pattern) for pattern in self.blacklist or ())


@dataclass(init=False, kw_only=True)
class VisualRandomizationConfig(RandomizationConfig):
    """Randomization of textures, lights and cameras.

    Args:
        image_directory: Folder with PNG or JPEG images; None selects a small set of patterns in the package.
        whitelist: Only these objects get textures; None: all objects.
        blacklist: These objects get no textures.
        randomize_arm: Put textures on the robot.
        textures: Put textures on objects. An object with a colour from its task keeps it; the texture only shades it.
        light: Strength of the changes of lights, from 0 (none) to 1 (strong).
        camera_shift: Standard deviation of the position of each camera [m].
        camera_turn: Standard deviation of the orientation of each camera [rad].

    Raises:
        NoTextureFolder: There is no such folder (also a NotADirectoryError).
        NoTextures: The folder has no images (also a RuntimeError).
    """

    rules: ClassVar[Mapping[str, Rule]] = {
        **RandomizationConfig.rules,
        **ruled((FLAG, "textures"), (NOT_NEGATIVE, "light camera_shift camera_turn")),
    }

    image_directory: Path
    textures: bool
    light: float
    camera_shift: float
    camera_turn: float
    _images: tuple[Path, ...] = field(repr=False)

    def __init__(
        self,
        image_directory: str | Path | None = None,
        whitelist: Sequence[str] | None = None,
        blacklist: Sequence[str] | None = None,
        randomize_arm: bool = True,
        *,
        textures: bool = True,
        light: float = 1.0,
        camera_shift: float = 0.0,
        camera_turn: float = 0.0,
    ) -> None:
        if image_directory is not None:
            image_directory = _as_folder(image_directory)
        super().__init__(whitelist=whitelist, blacklist=blacklist, randomize_arm=randomize_arm)
        self.image_directory = asset_path("textures") if image_directory is None else Path(image_directory)
        self.textures, self.light, self.camera_shift, self.camera_turn = textures, light, camera_shift, camera_turn
        self._images = images_in(self.image_directory)

    def sample(self, samples: int, rng: np.random.Generator | None = None) -> list[Path]:
        """Draw images, with replacement.

        Args:
            samples: Number of images.
            rng: Generator of the draws; without one, each call returns other images.
        """
        rng = np.random.default_rng() if rng is None else rng
        return [self._images[i] for i in rng.integers(len(self._images), size=samples).tolist()]


def images_in(folder: Path) -> tuple[Path, ...]:
    """Return the images of a folder by name; raise NoTextureFolder or NoTextures."""
    if not folder.is_dir():
        raise NoTextureFolder(f"The texture folder '{folder}' does not exist. Pass a folder of PNG or JPEG images, or None.")
    try:
        images = tuple(sorted(path for path in folder.iterdir() if path.suffix.lower() in _IMAGE_SUFFIXES))
    except OSError as error:
        raise NoTextures(f"The texture folder '{folder}' cannot be read: {error}. Check its permissions.") from error
    if not images:
        raise NoTextures(f"The texture folder '{folder}' has no .png or .jpg files. Add some, or pass None.")
    return images


@dataclass(kw_only=True)
class DynamicsRandomizationConfig(RandomizationConfig):
    """Ranges of the factors by which physical properties are multiplied: lowest and highest value."""

    rules: ClassVar[Mapping[str, Rule]] = {
        **RandomizationConfig.rules,
        **ruled((_as_factors, "mass friction damping gains")),
    }

    mass: tuple[float, float] = (0.8, 1.25)
    """Factor of the mass of movable bodies; their inertia is scaled too."""
    friction: tuple[float, float] = (0.8, 1.25)
    """Factor of the friction of bodies and of the table."""
    damping: tuple[float, float] = (0.8, 1.25)
    """Factor of the damping of joints of bodies."""
    gains: tuple[float, float] = (0.9, 1.1)
    """Factor of the gains of the arm motors, with `randomize_arm`."""


def check_randomization(every: RandomizeEvery | None, frequency: int, visual: object | None, dynamics: object | None) -> None:
    """Raise RandomizationMisused if the randomization arguments are invalid or contradict each other."""
    if every is not None and visual is None and dynamics is None:
        raise RandomizationMisused("randomize_every was given without a randomization config. Pass a visual or a dynamics one.")
    if every is None and (visual is not None or dynamics is not None):
        raise RandomizationMisused("A randomization config was given without randomize_every. Pass RandomizeEvery.EPISODE.")
    if visual is not None and not isinstance(visual, VisualRandomizationConfig):
        raise RandomizationMisused(f"visual_randomization_config must be a VisualRandomizationConfig, not {shown(visual)}.")
    if dynamics is not None and not isinstance(dynamics, DynamicsRandomizationConfig):
        raise RandomizationMisused(f"dynamics_randomization_config must be a DynamicsRandomizationConfig, not {shown(dynamics)}.")
    if every is not None and not isinstance(every, RandomizeEvery):
        raise RandomizationMisused(
            f"randomize_every has to be a RandomizeEvery such as RandomizeEvery.EPISODE, not {shown(every)}."
        )
    if not is_whole(frequency) or frequency < 1:
        raise RandomizationMisused(f"frequency has to be an integer of at least 1, not {shown(frequency)}.")
