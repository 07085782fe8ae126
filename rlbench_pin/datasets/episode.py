"""One episode file, read only as far as it is asked: the head at once, frames and fields when they are used."""

from __future__ import annotations

import io
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np

from rlbench_pin.datasets.manifest import digest
from rlbench_pin.datasets.series import from_json, read_series
from rlbench_pin.datasets.writer import DESCRIPTIONS, FORMAT, VERSION
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.observation import Demo, Observation, RandomState

_MAX_FRAMES = 10_000_000


class Episode:
    """An open episode file. Use it in a `with` block; `len(episode)` frames, `episode[i]` is one observation.

    Args:
        path: The file.
        sha256: What its bytes must add up to; None leaves them unchecked, and reads only what is used.

    Raises:
        EpisodeFileError: The file is missing, truncated, damaged, altered, or of another format or version; names the file.
    """

    def __init__(self, path: Path, sha256: str | None = None) -> None:
        self.path, self._is_closed = Path(path), False
        if not self.path.is_file():
            raise EpisodeFileError(self.path, f"The episode '{self.path}' does not exist.")
        with self._named():
            source = self.path if sha256 is None else io.BytesIO(_checked_bytes(self.path, sha256))
            self._file = h5py.File(source, "r")
        try:
            with self._named():
                self._check_version()
                self._check_links()
                self._length = int(self._file.attrs["frames"])
                if not 0 < self._length <= _MAX_FRAMES:
                    raise ValueError(f"{self._length} frames")
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
            return str(self._file.attrs["task"])

    @property
    def variation(self) -> int:
        """Variation of the task."""
        with self._named():
            return int(self._file.attrs["variation"])

    @property
    def instructions(self) -> tuple[str, ...]:
        """Sentences that describe the goal."""
        with self._named():
            return tuple(from_json(self._file.attrs["instructions"]))

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the fields of observations that are stored."""
        with self._named():
            return tuple(sorted(name for name in self._file["observations"] if "@" not in name))

    def shape(self, field: str) -> tuple[int, ...]:
        """Return the shape that a field of arrays has in one frame."""
        with self._named():
            return tuple(self._file["observations"][field].shape[1:])

    # Reading ----------------------------------------------------------------------------------------------------

    def __getitem__(self, index: int) -> Observation:
        """Read one frame; pictures are stored frame by frame, so this reads no other."""
        if not -self._length <= index < self._length:
            raise IndexError(f"frame {index} of {self._length}")
        return self.observations(range(index % self._length, index % self._length + 1))[0]

    def __iter__(self) -> Iterator[Observation]:
        return (self[i] for i in range(self._length))

    def series(self, field: str, frames: range | None = None) -> list[Any]:
        """Read one field of some frames, all when None; a frame without it has None."""
        with self._named():
            return read_series(self._file["observations"], field, self._length, frames)

    def array(self, field: str) -> np.ndarray:
        """Read one field of all frames, stacked along the first axis.

        Raises:
            DatasetError: The field is not stored for every frame.
        """
        values = self.series(field) if field in self.fields else [None]
        if any(v is None for v in values):
            held = f"It holds {', '.join(self.fields)}." if self.fields else "It holds no fields at all."
            raise DatasetError(f"'{self.path}' does not hold '{field}' for every frame. {held}")
        return np.stack([np.asarray(v) for v in values])

    def misc(self, key: str) -> list[Any]:
        """Read one key of `misc` for all frames; None where a frame has none, or all when no frame has it."""
        with self._named():
            if key == DESCRIPTIONS and self._describes:
                return [list(self.instructions) for _ in range(self._length)]
            group = self._file["misc"]
            return read_series(group, key, self._length) if key in group else [None] * self._length

    def observations(self, frames: range | None = None, fields: Collection[str] | None = None) -> list[Observation]:
        """Read frames, all when None, with some fields, all when None; `misc` always comes along."""
        frames = range(self._length) if frames is None else frames
        with self._named():
            group, misc = self._file["observations"], self._file["misc"]
            wanted = [name for name in self.fields if fields is None or name in fields]
            columns = {name: read_series(group, name, self._length, frames) for name in wanted}
            extras = {key: read_series(misc, key, self._length, frames) for key in misc if "@" not in key}
            if self._describes:
                extras[DESCRIPTIONS] = [list(self.instructions) for _ in frames]
        return [_observation(columns, extras, i) for i in range(len(frames))]

    def demo(self, fields: Collection[str] | None = None) -> Demo:
        """Read everything, or everything but some fields."""
        with self._named():
            attrs = self._file.attrs
            return Demo(
                self.observations(fields=fields),
                random_seed=_seed(attrs),
                num_reset_attempts=_optional_int(attrs, "num_reset_attempts"),
                variation_number=self.variation,
                instructions=self.instructions,
                state=_read_state(self._file),
                versions=from_json(attrs["versions"]),
                attempt=int(attrs["attempt"]),
                task_name=self.task_name,
            )

    @property
    def _describes(self) -> bool:
        """Whether every frame has the instructions in its `misc`."""
        return bool(self._file.attrs.get(DESCRIPTIONS, False))

    # Trust ------------------------------------------------------------------------------------------------------

    def _check_version(self) -> None:
        if self._file.attrs.get("format") != FORMAT:
            raise EpisodeFileError(
                self.path, f"'{self.path}' is an HDF5 file, but not an episode. `rlbench-pin record` makes some."
            )
        version = int(self._file.attrs.get("version", -1))
        if version != VERSION:
            raise EpisodeFileError(
                self.path,
                f"The episode '{self.path}' has format version {version}; this package reads version {VERSION}. "
                "Read it with the release of rlbench_pin that wrote it, or record it again.",
            )

    def _check_links(self) -> None:
        """Refuse what would read other files: links out of the file, external storage, virtual datasets."""
        for group in (self._file, *(self._file[name] for name in ("observations", "misc"))):
            for name in group:
                if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                    raise EpisodeFileError(
                        self.path, f"'{self.path}' has a link at '{name}' that leads elsewhere. Do not trust it."
                    )
                thing = group[name]
                if isinstance(thing, h5py.Dataset) and (thing.external or thing.is_virtual):
                    raise EpisodeFileError(self.path, f"'{self.path}' keeps '{name}' in another file. Do not trust it.")

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Turn whatever a damaged file raises into an error that names it; refuse to read what was closed."""
        if self._is_closed:
            raise EpisodeFileError(
                self.path, f"The episode '{self.path}' was closed. Read it inside its `with` block, or open it again."
            )
        try:
            yield
        except (OSError, KeyError, ValueError, TypeError, RuntimeError, MemoryError) as error:
            if isinstance(error, DatasetError):
                raise
            raise EpisodeFileError(
                self.path, f"The episode '{self.path}' is truncated or damaged ({error}). Delete it and record it again."
            ) from error


def _checked_bytes(path: Path, sha256: str) -> bytes:
    data = path.read_bytes()
    if digest(data) != sha256:
        raise EpisodeFileError(
            path, f"'{path}' is not the file its manifest describes: the SHA-256 differs. Delete it and record it again."
        )
    return data


def _observation(columns: dict[str, list[Any]], extras: dict[str, list[Any]], index: int) -> Observation:
    known = {name: values[index] for name, values in columns.items() if name in Observation.__dataclass_fields__}
    observation = Observation(**known, misc={key: v[index] for key, v in extras.items() if v[index] is not None})
    for name in columns.keys() - known.keys():
        setattr(observation, name, columns[name][index])
    return observation


def _seed(attrs: h5py.AttributeManager) -> int | RandomState | None:
    return tuple(from_json(attrs["random_state"])) if "random_state" in attrs else _optional_int(attrs, "random_seed")


def _read_state(file: h5py.File) -> dict[str, np.ndarray] | None:
    if "state" not in file:
        return None
    group = file["state"]
    names = sorted((name for name in group if "@" not in name), key=lambda n: int(n.removeprefix("array")))
    return {str(group[name].attrs["name"]): read_series(group, name, 1)[0] for name in names}


def _optional_int(attrs: h5py.AttributeManager, name: str) -> int | None:
    return int(attrs[name]) if name in attrs else None
