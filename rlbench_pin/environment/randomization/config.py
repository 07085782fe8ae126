"""Domain randomization: when it happens and what may change."""

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
    """The event that brings a new appearance or new dynamics."""

    EPISODE = "episode"
    """Each reset."""
    VARIATION = "variation"
    """Each reset to another variation than the last one's."""
    TRANSITION = "transition"
    """Each control tick."""


class RandomizationMisused(TaskEnvironmentError, ValueError):
    """Randomization was switched on in a way that makes no sense."""


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
    """Which objects may change. Names are those of bodies, of the room (`table`, `floor`, `wall_front`...) and of the robot."""

    rules: ClassVar[Mapping[str, Rule]] = ruled((_as_patterns, "whitelist blacklist"), (FLAG, "randomize_arm"))

    whitelist: Sequence[str] | None = None
    """Only these change; `*` and `?` are wildcards. None: all."""
    blacklist: Sequence[str] | None = None
    """These never change, even when they are on the white list."""
    randomize_arm: bool = True
    """Whether the robot changes."""

    def should_randomize(self, name: str) -> bool:
        """Whether the object called `name` may change."""
        if self.whitelist is not None and not any(fnmatchcase(name, pattern) for pattern in self.whitelist):
            return False
        return not any(fnmatchcase(name, pattern) for pattern in self.blacklist or ())


@dataclass(init=False, kw_only=True)
class VisualRandomizationConfig(RandomizationConfig):
    """Textures, lights and cameras.

    Args:
        image_directory: Folder with PNG or JPEG images; None is a small set of patterns that comes with the package.
        whitelist: Only these objects get textures.
        blacklist: These never do.
        randomize_arm: Whether the robot does.
        textures: Put textures on objects. An object to which its task gave a colour keeps it; the texture only shades it.
        light: How much lights change: 0 not at all, 1 strongly.
        camera_shift: Standard deviation of each camera's position [m].
        camera_turn: Standard deviation of each camera's orientation [rad].

    Raises:
        NoTextureFolder: There is no such folder (also a NotADirectoryError).
        NoTextures: It has no images (also a RuntimeError).
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
            samples: How many.
            rng: Draws them; without one, every call draws others.
        """
        rng = np.random.default_rng() if rng is None else rng
        return [self._images[i] for i in rng.integers(len(self._images), size=samples).tolist()]


def images_in(folder: Path) -> tuple[Path, ...]:
    """Return the images of a folder by name; raises NoTextureFolder or NoTextures."""
    if not folder.is_dir():
        raise NoTextureFolder(f"The texture folder '{folder}' does not exist. Pass a folder of PNG or JPEG images, or None.")
    try:
        images = tuple(sorted(path for path in folder.iterdir() if path.suffix.lower() in _IMAGE_SUFFIXES))
    except OSError as error:
        raise NoTextures(f"The texture folder '{folder}' cannot be read: {error}. Check its permissions.") from error
    if not images:
        raise NoTextures(f"The texture folder '{folder}' has no .png or .jpg files. Put some there, or pass None.")
    return images


@dataclass(kw_only=True)
class DynamicsRandomizationConfig(RandomizationConfig):
    """Factors that physical properties are multiplied by, drawn between a lowest and a highest value."""

    rules: ClassVar[Mapping[str, Rule]] = {
        **RandomizationConfig.rules,
        **ruled((_as_factors, "mass friction damping gains")),
    }

    mass: tuple[float, float] = (0.8, 1.25)
    """Of bodies that move; inertia follows."""
    friction: tuple[float, float] = (0.8, 1.25)
    """Of bodies and the table."""
    damping: tuple[float, float] = (0.8, 1.25)
    """Of the joints of bodies."""
    gains: tuple[float, float] = (0.9, 1.1)
    """Of the arm's motors, when `randomize_arm`."""


def check_randomization(every: RandomizeEvery | None, frequency: int, visual: object | None, dynamics: object | None) -> None:
    """Raise unless the randomization arguments make sense together."""
    if every is not None and visual is None and dynamics is None:
        raise RandomizationMisused("randomize_every was given without a randomization config. Pass a visual or a dynamics one.")
    if every is None and (visual is not None or dynamics is not None):
        raise RandomizationMisused("A randomization config was given without randomize_every. Pass RandomizeEvery.EPISODE.")
    if visual is not None and not isinstance(visual, VisualRandomizationConfig):
        raise RandomizationMisused(f"visual_randomization_config must be a VisualRandomizationConfig, not {shown(visual)}.")
    if dynamics is not None and not isinstance(dynamics, DynamicsRandomizationConfig):
        raise RandomizationMisused(f"dynamics_randomization_config must be a DynamicsRandomizationConfig, not {shown(dynamics)}.")
    if every is not None and not isinstance(every, RandomizeEvery):
        raise RandomizationMisused(f"randomize_every is a RandomizeEvery such as RandomizeEvery.EPISODE, not {shown(every)}.")
    if not is_whole(frequency) or frequency < 1:
        raise RandomizationMisused(f"frequency counts events and is at least 1, not {shown(frequency)}.")
