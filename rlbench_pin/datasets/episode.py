"""Reader of episode files: attributes are read when a file is opened, frames and fields on demand."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from rlbench_pin.datasets.inspection_child import is_oversized
from rlbench_pin.datasets.manifest import LARGEST, MAX_FRAMES, ONLY_ARM, is_text_map, is_texts, is_whole, short
from rlbench_pin.datasets.series import from_json, read_series
from rlbench_pin.datasets.trust import Inspector, check_file, file_stamp
from rlbench_pin.datasets.writer import DESCRIPTIONS, FORMAT, VERSION
from rlbench_pin.errors import DatasetError, EpisodeFileError, InvalidValue
from rlbench_pin.observation import Demo, Observation, RandomState
from rlbench_pin.values import as_names, as_path, as_record, as_text

_MAX_VARIATIONS = 2**31 - 1
_LONGEST_NAME = 1000
_LONGEST_FACTORS = 10_000
_ONLY_JOINTS = tuple(f"panda_joint{i}" for i in range(1, 8))
"""Joints of `ONLY_ARM`, the arm of episodes that do not name theirs."""


@dataclass(frozen=True)
class Head:
    """The attributes of an episode."""

    frames: int
    task: str
    task_version: int
    """1 where it is not recorded."""
    variation: int
    attempt: int
    instructions: tuple[str, ...]
    versions: dict[str, str]
    robot: str
    """Empty where it is not named."""
    joint_names: tuple[str, ...]
    factors: str
    """Factors of generalisation; empty without."""
    random_seed: int | RandomState | None
    num_reset_attempts: int | None
    describes: bool
    """Whether every frame has the instructions in its `misc`."""


def read_head(attributes: dict[str, Any]) -> Head:
    """Check the attributes of an episode, with their JSON texts parsed.

    Raises:
        ValueError: An attribute is missing or invalid; the message names it and its value.
    """
    task, instructions, versions = (attributes.get(name) for name in ("task", "instructions", "versions"))
    if not isinstance(task, str) or len(task) > _LONGEST_NAME:
        raise ValueError(f"its task is {short(task)}, not a name")
    if not is_texts(instructions):
        raise ValueError(f"its instructions are {short(instructions)}, not a list of texts")
    if not is_text_map(versions):
        raise ValueError(f"its versions are {short(versions)}, not texts by name")
    robot, joints, factors = (
        attributes.get(name, other) for name, other in (("robot", ""), ("joint_names", []), ("factors", ""))
    )
    if not isinstance(robot, str) or len(robot) > _LONGEST_NAME:
        raise ValueError(f"its robot is {short(robot)}, not a name")
    if not isinstance(factors, str) or len(factors) > _LONGEST_FACTORS:
        raise ValueError(f"its factors are {short(factors)}, not a setting such as light_color:2")
    if not is_texts(joints):
        raise ValueError(f"its joint names are {short(joints)}, not a list of texts")
    assert isinstance(instructions, list) and isinstance(versions, dict) and isinstance(joints, list)
    resets = "num_reset_attempts"
    return Head(
        frames=_whole(attributes, "frames", 1, MAX_FRAMES),
        task=task,
        task_version=_whole(attributes, "task_version", 1) if "task_version" in attributes else 1,
        variation=_whole(attributes, "variation", 0, _MAX_VARIATIONS),
        attempt=_whole(attributes, "attempt"),
        instructions=tuple(instructions),
        versions=versions,
        robot=robot,
        joint_names=tuple(joints),
        factors=factors,
        random_seed=_seed(attributes),
        num_reset_attempts=_whole(attributes, resets) if resets in attributes else None,
        describes=_flag(attributes, "descriptions"),
    )


def _seed(attributes: dict[str, Any]) -> int | RandomState | None:
    if "random_state" in attributes:
        state = attributes["random_state"]
        if not isinstance(state, tuple | list):
            raise ValueError(f"its random_state is {short(state)}, not the state of a generator")
        return tuple(state)
    return _whole(attributes, "random_seed") if "random_seed" in attributes else None


def _whole(attributes: dict[str, Any], name: str, low: int = 0, high: int = LARGEST) -> int:
    value: Any = attributes.get(name)
    plain = value.item() if isinstance(value, np.integer) else value
    if not is_whole(plain, low, high):
        raise ValueError(f"its {name} is {short(plain)}, not a whole number from {low} to {high}")
    return int(plain)


def _flag(attributes: dict[str, Any], name: str) -> bool:
    value = attributes.get(name, False)
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"its {name} is {short(value)}, neither true nor false")
    return bool(value)


_GROUPS = ("observations", "misc")
_JSON = ("instructions", "versions", "joint_names", "random_state")
"""Attributes that are JSON."""


class Episode:
    """An open episode file. Use it in a `with` block; `len(episode)` is the number of frames, `episode[i]` one observation.

    A file is opened if its SHA-256 equals that in its manifest, or if a subprocess has read it without a crash. A process does
    this check once for each file, and again when size or modification time of the file change. Only requested data is read.

    Args:
        path: The file.
        sha256: Expected SHA-256 of the file. None takes it from the manifest of the dataset that contains the file.
        inspector: Reads the file first if no manifest lists it. None starts a subprocess for that.

    Raises:
        EpisodeFileError: The file is missing, truncated, damaged, altered, harmful, or of another format or version. The
            message names the file.
    """

    def __init__(self, path: Path, sha256: str | None = None, inspector: Inspector | None = None) -> None:
        self.path, self._is_closed = as_path(path, "path"), False
        if sha256 is not None:
            as_text(sha256, "sha256")
        if not self.path.is_file():
            raise EpisodeFileError(self.path, f"The episode '{self.path}' does not exist. Check the path.")
        with self._named():
            stamp = file_stamp(self.path)
            check_file(self.path, sha256, inspector)
            self._file = h5py.File(self.path, "r")
        try:
            with self._named():
                if file_stamp(self.path) != stamp:
                    raise EpisodeFileError(self.path, f"'{self.path}' was changed while it was opened. Open it again.")
                attributes = dict(self._file.attrs)
                self._check_version(attributes)
                self._groups, self._sound = self._checked_groups(), set[tuple[str, str]]()
                self._fields = tuple(sorted(name for name in self._groups["observations"] if "@" not in name))
                self._head = read_head({name: from_json(v) if name in _JSON else v for name, v in attributes.items()})
                self._length = self._head.frames
        except DatasetError:
            self._file.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._is_closed = True
        self._file.close()

    def __enter__(self) -> Episode:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    # What it holds ----------------------------------------------------------------------------------------------

    def __len__(self) -> int:
        return self._length

    @property
    def task_name(self) -> str:
        """Snake-case task name."""
        with self._named():
            return self._head.task

    @property
    def task_version(self) -> int:
        """Version of the task; 1 in files that do not record it."""
        return self._head.task_version

    @property
    def variation(self) -> int:
        """Variation of the task."""
        with self._named():
            return self._head.variation

    @property
    def robot(self) -> str:
        """Name of the arm."""
        return self._head.robot or ONLY_ARM

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints of the arm, in the order of joint positions."""
        return self._head.joint_names if self._head.robot else _ONLY_JOINTS

    @property
    def instructions(self) -> tuple[str, ...]:
        """Instructions: sentences that describe the goal."""
        return self._head.instructions

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the stored observation fields."""
        with self._named():
            return self._fields

    def shape(self, field: str) -> tuple[int, ...]:
        """Return the shape of an array field in one frame; raise DatasetError if the field is not stored."""
        self._check_held(field)
        with self._named():
            return tuple(self._dataset("observations", field).shape[1:])

    # Reading ----------------------------------------------------------------------------------------------------

    def __getitem__(self, index: int) -> Observation:
        """Read one frame. Images are stored in chunks of four frames, so this reads at most three other frames."""
        if not -self._length <= index < self._length:
            most = self._length - 1
            raise IndexError(f"There is no frame {index}: the episode has {self._length}. Choose an index up to {most}.")
        return self.observations(range(index % self._length, index % self._length + 1))[0]

    def __iter__(self) -> Iterator[Observation]:
        return (self[i] for i in range(self._length))

    def series(self, field: str, frames: range | None = None) -> list[Any]:
        """Read one field of consecutive frames, by default of all; the value is None for a frame without the field.

        Raises:
            DatasetError: The field is not stored.
            InvalidValue: The episode does not have these frames.
        """
        self._check_held(field)
        frames = self._checked_frames(frames)
        with self._named():
            return self._read("observations", field, frames)

    def array(self, field: str) -> np.ndarray:
        """Read one field of all frames, stacked along the first axis.

        Raises:
            DatasetError: The field is not stored for every frame.
        """
        values = self.series(field)
        if any(v is None for v in values):
            raise self._not_held(field, " for every frame")
        return np.stack([np.asarray(v) for v in values])

    def misc(self, key: str) -> list[Any]:
        """Read one key of `misc` for all frames; the value is None for a frame without the key."""
        as_text(key, "key")
        with self._named():
            if key == DESCRIPTIONS and self._head.describes:
                return [list(self.instructions) for _ in range(self._length)]
            return self._read("misc", key) if key in self._groups["misc"] else [None] * self._length

    def observations(self, frames: range | None = None, fields: Collection[str] | None = None) -> list[Observation]:
        """Read some fields of some frames, by default all fields of all frames; `misc` is always read."""
        frames = self._checked_frames(frames)
        fields = None if fields is None else as_names(fields, "fields")
        with self._named():
            wanted = [name for name in self.fields if fields is None or name in fields]
            columns = {name: self._read("observations", name, frames) for name in wanted}
            extras = {key: self._read("misc", key, frames) for key in self._groups["misc"] if "@" not in key}
            if self._head.describes:
                extras[DESCRIPTIONS] = [list(self.instructions) for _ in frames]
        return [_observation(columns, extras, i) for i in range(len(frames))]

    def demo(self, fields: Collection[str] | None = None) -> Demo:
        """Read the whole demonstration, or only some of its fields; `misc` is always read."""
        head, observations = self._head, self.observations(fields=fields)
        with self._named():
            return Demo(
                observations,
                random_seed=head.random_seed,
                num_reset_attempts=head.num_reset_attempts,
                variation_number=head.variation,
                instructions=head.instructions,
                state=self._read_state(),
                versions=head.versions,
                attempt=head.attempt,
                task_name=head.task,
                robot=head.robot,
                joint_names=head.joint_names,
                factors=head.factors,
                task_version=head.task_version,
            )

    def _read_state(self) -> dict[str, np.ndarray] | None:
        if "state" not in self._groups:
            return None
        group = self._groups["state"]
        names = sorted((name for name in group if "@" not in name), key=lambda n: int(n.removeprefix("array")))
        return {str(group[name].attrs["name"]): self._read("state", name, length=1)[0] for name in names}

    # What is asked for ------------------------------------------------------------------------------------------

    def _check_held(self, field: str) -> None:
        """Raise DatasetError for a field that is not stored; the file is not damaged."""
        if as_text(field, "field") not in self.fields:
            raise self._not_held(field)

    def _not_held(self, field: str, where: str = "") -> DatasetError:
        held = f"Stored fields: {', '.join(self.fields)}." if self.fields else "It has no fields. Record the field."
        return DatasetError(f"'{self.path}' has no field '{field}'{where}. {held}")

    def _checked_frames(self, frames: range | None) -> range:
        """Return the frames to be read, all for None; or raise InvalidValue."""
        if frames is None:
            return range(self._length)
        if as_record(frames, range, "frames").step != 1 or not 0 <= frames.start <= frames.stop <= self._length:
            raise InvalidValue("frames", frames, f"has to be a range with step 1 in the {self._length} frames of the episode")
        return frames

    # Trust ------------------------------------------------------------------------------------------------------

    def _check_version(self, attributes: dict[str, Any]) -> None:
        if attributes.get("format") != FORMAT:
            raise EpisodeFileError(
                self.path, f"'{self.path}' is an HDF5 file, but not an episode. Use `rlbench-pin record` to create episodes."
            )
        version = attributes.get("version", -1)
        if not isinstance(version, int | np.integer):
            raise ValueError("its version is not a number")
        if version != VERSION:
            raise EpisodeFileError(
                self.path,
                f"The episode '{self.path}' has format version {version}; this package reads version {VERSION}. "
                "Read it with the release of rlbench_pin that wrote it, or record it again.",
            )

    def _checked_groups(self) -> dict[str, h5py.Group]:
        """Return the groups of the file, which is made of groups alone."""
        for name in self._file:
            self._check_link(self._file, name)
        groups = {name: self._file[name] for name in self._file}
        for name in {*groups, *_GROUPS}:
            if not isinstance(groups.get(name), h5py.Group):
                raise ValueError(f"'{name}' is missing, or is not a group")
        return groups

    def _dataset(self, place: str, name: str) -> h5py.Dataset:
        """Return a dataset; raise an error for links, external storage and false sizes, which read other files or too much."""
        group = self._groups[place]
        if (place, name) in self._sound:
            return group[name]
        self._check_link(group, name)
        dataset = group[name]
        if not isinstance(dataset, h5py.Dataset):
            raise ValueError(f"'{name}' is missing, or is not a dataset")
        if dataset.external or dataset.is_virtual:
            raise EpisodeFileError(self.path, f"'{self.path}' stores '{name}' in another file. Do not trust it: delete it.")
        if is_oversized(dataset):
            raise ValueError(f"'{name}' claims more values than are stored")
        self._sound.add((place, name))
        return dataset

    def _read(self, place: str, name: str, frames: range | None = None, length: int | None = None) -> list[Any]:
        """Read a series of a group whose datasets are checked first."""
        group, beside = self._groups[place], f"{name}@frames"
        rows = self._dataset(place, beside) if beside in group else None
        return read_series(self._dataset(place, name), rows, self._length if length is None else length, frames)

    def _check_link(self, group: h5py.Group, name: str) -> None:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            problem = f"'{self.path}' has a link at '{name}' that leads elsewhere"
            raise EpisodeFileError(self.path, f"{problem}. Do not trust it: delete it.")

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Convert any error of a damaged file to an EpisodeFileError that names the file; refuse to read a closed file."""
        if self._is_closed:
            raise EpisodeFileError(
                self.path, f"The episode '{self.path}' was closed. Read it inside its `with` block, or open it again."
            )
        try:
            yield
        except DatasetError:
            raise
        except Exception as error:  # damaged files raise nearly everything
            raise EpisodeFileError(
                self.path, f"The episode '{self.path}' is truncated or damaged ({error}). Delete it and record it again."
            ) from error


def _observation(columns: dict[str, list[Any]], extras: dict[str, list[Any]], index: int) -> Observation:
    known = {name: values[index] for name, values in columns.items() if name in Observation.__dataclass_fields__}
    observation = Observation(**known, misc={key: v[index] for key, v in extras.items() if v[index] is not None})
    for name in columns.keys() - known.keys():
        setattr(observation, name, columns[name][index])
    return observation
