"""Settings of a recording, its work items, and the file `recording.json` with the settings of a dataset."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, get_args

from rlbench_pin.datasets.layout import ALL_VARIATIONS
from rlbench_pin.datasets.manifest import parse_json, short
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.datasets.writer import Compression
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.episode import drawn_variations
from rlbench_pin.environment.factors import FactorSetting
from rlbench_pin.environment.observations.config import ObservationConfig, RenderMode
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.recovery import as_disturbances
from rlbench_pin.errors import EpisodeFileError, InvalidArgument, InvalidCamera, RlbenchPinError, TaskEnvironmentError
from rlbench_pin.observation import CAMERAS, PRODUCTS, Disturbance
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.sim import RENDERERS, RendererName
from rlbench_pin.tasks import Task, find_task, task_digest
from rlbench_pin.values import (
    as_choice,
    as_flag,
    as_image_size,
    as_names,
    as_number,
    as_path,
    as_record,
    as_seed,
    as_several,
    as_text,
    as_whole,
    items_of,
)

MOST = 10_000_000
"""Maximum number of episodes, attempts and variations of one recording."""
_SEED_BITS = 53  # so that JSON readers of every language keep the number; evaluations have theirs beyond
RECORDING = "recording.json"
VERSION = 1


@dataclass(frozen=True, kw_only=True)
class ImageConfig:
    """The images of recorded episodes: cameras, products, size, renderer and compression."""

    cameras: tuple[str, ...] = CAMERAS
    """Cameras whose images are stored."""
    products: tuple[str, ...] = ("rgb", "depth", "mask")
    """Images of each camera: rgb, depth, mask, point_cloud; none for episodes without images."""
    image_size: tuple[int, int] = (128, 128)
    """Width and height of the images [px]."""
    renderer: RendererName = "cpu"
    """Renderer; `cpu` gives the same images on every machine."""
    render_mode: RenderMode = "opengl3"
    """`opengl3` draws shadows; `opengl` draws none and is faster."""
    compression: Compression = "gzip"
    """Compression: `gzip` gives smaller files, `lzf` is faster."""

    def __post_init__(self) -> None:
        """Raise UnknownName or InvalidCamera for images that cannot be stored."""
        object.__setattr__(self, "image_size", as_image_size(self.image_size, "ImageConfig.image_size", InvalidCamera))
        _check_names("camera", self.cameras, CAMERAS)
        _check_names("product", self.products, PRODUCTS)
        as_choice(self.renderer, "renderer", RENDERERS)
        as_choice(self.compression, "compression", get_args(Compression))
        as_choice(self.render_mode, "render mode", get_args(RenderMode))
        self.obs_config().check()

    def obs_config(self) -> ObservationConfig:
        """Return the observation config: all joint, gripper and task data, and these images."""
        config = low_dim_config()
        for name in self.cameras:
            camera = config.camera(name)
            camera.image_size, camera.render_mode = self.image_size, self.render_mode
            for product in self.products:
                setattr(camera, product, True)
        return config

    def fields(self) -> dict[str, tuple[int, ...]]:
        """Return the image fields of an episode and their shapes."""
        plain = self.image_size[::-1]
        shapes = {"rgb": (*plain, 3), "depth": plain, "mask": plain, "point_cloud": (*plain, 3)}
        return {f"{camera}_{product}": shapes[product] for camera in self.cameras for product in self.products}

    def environment(self, max_velocity: float = 1.0, max_acceleration: float = 4.0, robot: str = DEFAULT_ROBOT) -> Environment:
        """Return an environment with these images and with the action mode of recorded demonstrations.

        Args:
            max_velocity: Limit of the speed along the joint-space path [rad/s].
            max_acceleration: Limit of the acceleration along the joint-space path [rad/s^2].
            robot: Name of the arm, or path of its TOML file.
        """
        return make_environment(self.obs_config(), self.renderer, max_velocity, max_acceleration, robot)


@dataclass(frozen=True, kw_only=True)
class RecordConfig:
    """Settings of a recording. The same settings give the same files for any number of workers."""

    tasks: tuple[str, ...]
    """Task names, or paths of task files."""
    episodes: int = 10
    """Number of episodes of each task, spread evenly over its variations; of each variation with `per_variation`."""
    per_variation: bool = False
    """Record `episodes` of each variation instead of each task."""
    variations: int = ALL_VARIATIONS
    """Maximum number of variations of a task; -1 is all."""
    draw_variations: bool = True
    """Draw the variations at random without repetition, the same ones in every run; otherwise take the first ones."""
    seed: int = 0
    """Seed of the recording. The seed of an episode is a hash of it, the task, the variation and the number of the episode."""
    max_attempts: int = 10
    """Maximum number of attempts for each episode."""
    max_velocity: float = 1.0
    """Limit of the speed along the joint-space path [rad/s]."""
    max_acceleration: float = 4.0
    """Limit of the acceleration along the joint-space path [rad/s^2]."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm, or path of its TOML file."""
    paired: tuple[str, ...] = ()
    """Other arms. An episode is stored only if all of them also demonstrate it, at the same attempt of the same seed."""
    images: ImageConfig = field(default_factory=ImageConfig)
    """Images of the episodes."""
    factors: str = ""
    """Factors of generalisation of all episodes, such as `light_color:2+friction:1`."""
    disturb: tuple[Disturbance, ...] = ()
    """Disturbances of which one happens in each episode: `push`, `slip`, `stop`; none when empty."""
    listed: Mapping[str, tuple[tuple[int, int], ...]] = field(default_factory=dict)
    """Task name -> variation and seed of each of its episodes. For these tasks it replaces the numbers and the seed above."""

    def __post_init__(self) -> None:
        """Check every value.

        Raises:
            InvalidArgument: A value cannot be used (also a TaskEnvironmentError).
            UnknownName: An arm or a factor does not exist.
        """
        as_seed(self.seed, "seed", InvalidArgument)
        object.__setattr__(self, "robot", robot_description(self.robot).reference)
        others = {robot_description(name).reference for name in as_names(self.paired, "paired", InvalidArgument)}
        object.__setattr__(self, "paired", tuple(sorted(others - {self.robot})))
        for name, least in (("episodes", 1), ("max_attempts", 1), ("variations", ALL_VARIATIONS)):
            as_whole(getattr(self, name), name, InvalidArgument, least=least, most=MOST)
        if self.variations == 0:
            raise InvalidArgument("variations", 0, "has to be -1 or at least 1", "Write -1 for all variations.")
        for name in ("max_velocity", "max_acceleration"):
            as_number(getattr(self, name), name, InvalidArgument, above=0.0)
        object.__setattr__(self, "factors", str(FactorSetting.of(as_text(self.factors, "factors", InvalidArgument))))
        object.__setattr__(self, "disturb", as_disturbances(self.disturb))
        as_record(self.images, ImageConfig, "images", InvalidArgument)
        for name in ("per_variation", "draw_variations"):
            as_flag(getattr(self, name), name, InvalidArgument)
        object.__setattr__(self, "listed", _checked_list(self.listed))
        if not as_names(self.tasks, "tasks", InvalidArgument):
            raise TaskEnvironmentError("No task was named. `rlbench-pin list` prints them.")


@dataclass(frozen=True)
class WorkItem:
    """One episode to make."""

    task: str
    """Task name, or path of a task file."""
    name: str
    """Task name."""
    variation: int
    """Variation of the task."""
    index: int
    """Number of the episode within its variation."""
    seed: int
    """Seed of the episode."""
    attempts: tuple[int, ...]
    """Maximum number of attempts of the seed, until one succeeds."""
    source: str = ""
    """Episode file whose motion the new episode must repeat; none when empty."""
    sha256: str = ""
    """SHA-256 of that file."""
    max_velocity: float = 1.0
    """Limit of the speed along the joint-space path [rad/s]."""
    max_acceleration: float = 4.0
    """Limit of the acceleration along the joint-space path [rad/s^2]."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm, or path of its TOML file."""
    paired: tuple[str, ...] = ()
    """Other arms that must also solve the attempt."""
    task_digest: str = ""
    """SHA-256 of the files of the task; not compared when empty."""
    factors: str = ""
    """Factors of generalisation; none when empty."""
    disturb: tuple[Disturbance, ...] = ()
    """Disturbances of which one happens."""

    @property
    def limits(self) -> tuple[float, float]:
        """Limits of velocity [rad/s] and acceleration [rad/s^2]."""
        return self.max_velocity, self.max_acceleration

    @property
    def key(self) -> tuple[str, int, int]:
        """Task, variation and number of the episode in the dataset."""
        return self.name, self.variation, self.index


def plan_items(config: RecordConfig, tasks: Mapping[str, type[Task]] | None = None) -> list[WorkItem]:
    """Return the episodes of a recording, task by task, variations in turn.

    Args:
        config: Settings of the recording.
        tasks: Name or path of the task, for the workers -> class; None finds the tasks that `config` names.

    Raises:
        UnknownName: A task does not exist.
    """
    tasks = {name: find_task(name) for name in config.tasks} if tasks is None else tasks
    items: list[WorkItem] = []
    with ImageConfig(products=()).environment(robot=config.robot) as environment:
        for name, task in tasks.items():
            running, files = environment.get_task(task), task_digest(task)
            running.set_factors(config.factors)  # raises an error for a factor that cannot change the task
            count = running.variation_count()
            if task.get_name() in config.listed:
                planned = _listed_items(config, name, task.get_name(), count)
            else:
                planned = _task_items(config, name, task.get_name(), _variations(config, count))
            items += [replace(item, task_digest=files) for item in planned] if files else planned
    return items


def _variations(config: RecordConfig, count: int) -> tuple[int, ...]:
    if config.draw_variations or config.variations == ALL_VARIATIONS:
        return drawn_variations(count, config.variations)
    return tuple(range(min(count, config.variations)))


def _task_items(config: RecordConfig, task: str, name: str, variations: Sequence[int]) -> list[WorkItem]:
    total = config.episodes * len(variations) if config.per_variation else config.episodes
    rounds = -(-total // len(variations))
    places = [(variation, index) for index in range(rounds) for variation in variations][:total]
    return [_item(config, task, name, *place) for place in places]


def _listed_items(config: RecordConfig, task: str, name: str, count: int) -> list[WorkItem]:
    """Return the episodes of a task that are listed; the first of a variation has the number 0."""
    items, indices = [], Counter[int]()
    for variation, seed in config.listed[name]:
        if variation >= count:
            raise InvalidArgument(f"A listed variation of '{name}'", variation, f"has to be below {count}", "Correct the list.")
        items.append(_item(config, task, name, variation, indices[variation], seed))
        indices[variation] += 1
    return items


def _item(config: RecordConfig, task: str, name: str, variation: int, index: int, seed: int | None = None) -> WorkItem:
    seed = item_seed(config.seed, name, variation, index) if seed is None else seed
    return WorkItem(
        task, name, variation, index, seed, tuple(range(config.max_attempts)),
        max_velocity=config.max_velocity, max_acceleration=config.max_acceleration,
        robot=config.robot, paired=config.paired, factors=config.factors, disturb=config.disturb,
    )  # fmt: skip


def item_seed(seed: int, task: str, variation: int, index: int) -> int:
    """Return the seed of one episode, 0 <= seed < 2^53: a hash of recording seed, task, variation and number."""
    name = f"{seed}/{task}/{variation}/{index}".encode()
    return int.from_bytes(hashlib.sha256(name).digest()[:8], "big") >> (64 - _SEED_BITS)


def _checked_list(listed: object) -> dict[str, tuple[tuple[int, int], ...]]:
    table = as_record(listed, Mapping, "listed", InvalidArgument)  # type: ignore[type-abstract]
    as_names(tuple(table), "listed", InvalidArgument)
    found = {}
    for name, episodes in table.items():
        pairs = [items_of(pair) for pair in as_several(episodes, f"listed episodes of '{name}'", InvalidArgument)]
        if not pairs or any(len(pair) != 2 for pair in pairs):
            raise InvalidArgument(f"listed episodes of '{name}'", episodes, "have to be pairs of variation and seed")
        found[name] = tuple(
            (as_whole(v, "A listed variation", InvalidArgument, least=0, most=MOST), as_seed(s, "A listed seed", InvalidArgument))
            for v, s in pairs
        )
    return found


def _check_names(kind: str, names: Sequence[str], known: Sequence[str]) -> None:
    for name in as_names(names, f"ImageConfig.{kind}s", InvalidArgument):
        as_choice(name, kind, known)


def read_recording(root: Path | str) -> RecordConfig:
    """Return the settings of the recording in a folder.

    Raises:
        DatasetError: There is no recording, or its settings cannot be read.
    """
    path = as_path(root, "root") / RECORDING
    if not path.exists():
        raise EpisodeFileError(
            path,
            f"'{path}' does not exist, so there is no recording to resume. Start one: `rlbench-pin record TASK... --out {root}`.",
        )
    try:
        content = parse_json(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict):
            raise ValueError("it is not a table")
        if (version := content.pop("version", None)) != VERSION:
            raise ValueError(f"it has version {short(version)}, this package reads version {VERSION}")
        images = content.pop("images" if "images" in content else "pictures", None)  # earlier versions wrote `pictures`
        if not isinstance(images, dict):
            raise ValueError("it has no table 'images'")
        config = RecordConfig(**_with_tuples(content), images=ImageConfig(**_with_tuples(images)))
        return replace(config, tasks=tuple(map(_stored_name, config.tasks)))
    except (OSError, ValueError, TypeError, RlbenchPinError) as error:
        raise EpisodeFileError(
            path,
            f"'{path}' does not describe a recording: {error}. Delete it, then run `rlbench-pin record` with `--resume`, the "
            "tasks and the settings. The stored episodes are kept.",
        ) from error


def common_flags(config: RecordConfig) -> dict[str, str]:
    """Return the settings that all episodes of a dataset share, as flags of `rlbench-pin record` and their values."""
    images = config.images
    return {
        "--seed": f"{config.seed}",
        "--max-attempts": f"{config.max_attempts}",
        "--robot": config.robot,
        "--factors": config.factors,
        "--disturb": " ".join(config.disturb),
        "--paired": " ".join(sorted({config.robot, *config.paired})) if config.paired else "",
        "--cameras": " ".join(images.cameras),
        "--products": " ".join(images.products),
        "--image-size": "{} {}".format(*images.image_size),
        "--renderer": images.render_mode,
        "--compression": images.compression,
        "ImageConfig.renderer": images.renderer,
    }


def all_flags(config: RecordConfig) -> dict[str, str]:
    """Return all settings of a recording, as flags of `rlbench-pin record` and their values."""
    return {
        "TASK": " ".join(config.tasks),
        "--episodes": f"{config.episodes}",
        "--per-variation": f"{config.per_variation}",
        "--variations": f"{config.variations}",
        "RecordConfig.draw_variations": f"{config.draw_variations}",
        "--arm-max-velocity": f"{config.max_velocity}",
        "--arm-max-acceleration": f"{config.max_acceleration}",
        **({"RecordConfig.listed": _digest(config.listed)} if config.listed else {}),
        **common_flags(config),
    }


def _digest(listed: Mapping[str, tuple[tuple[int, int], ...]]) -> str:
    """Return a short text that is equal for equal lists."""
    count = sum(map(len, listed.values()))
    return f"{count} episodes ({hashlib.sha256(json.dumps(listed, sort_keys=True).encode()).hexdigest()[:12]})"


def write_recording(root: Path, config: RecordConfig) -> None:
    """Write the settings, so that `--resume` needs only the folder."""
    content = {"version": VERSION, **asdict(config)}
    if not config.listed:
        del content["listed"]
    write_whole(root / RECORDING, (json.dumps(content, indent=1) + "\n").encode())


def _stored_name(task: str) -> str:
    """Return the name of a task in a recording; a path to code, as in older files, is not opened."""
    name = Path(task).stem
    if not name.isidentifier():
        raise ValueError(f"{task!r} names no task")
    return name


def _with_tuples(settings: dict[str, Any]) -> dict[str, Any]:
    return {name: tuple(value) if isinstance(value, list) else value for name, value in settings.items()}
