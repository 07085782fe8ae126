"""Writing demonstrations: aside first, checksummed, renamed when whole."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

import h5py

from rlbench_pin.datasets.layout import EPISODE_SUFFIX, episode_path
from rlbench_pin.datasets.manifest import EpisodeEntry, file_digest, locked_manifest
from rlbench_pin.datasets.series import to_json, write_series
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import Demo, Observation

FORMAT = "rlbench_pin.episode"
VERSION = 1

FIELDS = tuple(f.name for f in fields(Observation) if f.name != "misc")

Compression = Literal["gzip", "lzf"]


def write_demo(demo: Demo, path: Path, compression: Compression = "gzip") -> Path:
    """Write one demonstration to one file; the file appears whole or not at all.

    Args:
        demo: What to write.
        path: The file, replaced when it exists.
        compression: `gzip` is small, `lzf` is fast; both keep every bit.

    Raises:
        DatasetError: The demo is empty or holds something that cannot be stored.
    """
    path = Path(path)
    if len(demo) == 0:
        raise DatasetError(f"A demonstration without observations cannot be written to '{path}'.")
    with _aside(path) as temporary, h5py.File(temporary, "w") as file:
        _write_head(file, demo)
        try:
            _write_observations(file, demo, compression)
        except TypeError as error:
            raise DatasetError(f"'{path}' cannot be written: {error}.") from error
        _write_state(file, demo, compression)
    return path


def _write_head(file: h5py.File, demo: Demo) -> None:
    file.attrs["format"] = FORMAT
    file.attrs["version"] = VERSION
    file.attrs["frames"] = len(demo)
    file.attrs["task"] = demo.task_name
    file.attrs["variation"] = demo.variation_number
    file.attrs["attempt"] = demo.attempt
    file.attrs["instructions"] = to_json(list(demo.instructions))
    file.attrs["versions"] = to_json(dict(demo.versions))
    if demo.random_seed is not None:
        file.attrs["random_seed"] = demo.random_seed
    if demo.num_reset_attempts is not None:
        file.attrs["num_reset_attempts"] = demo.num_reset_attempts


def _write_observations(file: h5py.File, demo: Demo, compression: str) -> None:
    group = file.create_group("observations")
    for name in FIELDS:
        write_series(group, name, [getattr(obs, name) for obs in demo], compression)
    misc = file.create_group("misc")
    for key in sorted({key for obs in demo for key in obs.misc}):
        if "/" in key or "@" in key:
            raise TypeError(f"the misc key '{key}' has a '/' or '@' in it")
        write_series(misc, key, [obs.misc.get(key) for obs in demo], compression)


def _write_state(file: h5py.File, demo: Demo, compression: str) -> None:
    if demo.state is None:
        return
    group = file.create_group("state")
    for index, (name, array) in enumerate(sorted(demo.state.items())):
        write_series(group, f"array{index}", [array], compression)
        group[f"array{index}"].attrs["name"] = name


@contextmanager
def _aside(path: Path) -> Iterator[Path]:
    """Yield a neighbouring name to write to; rename it to `path` at the end, or remove it after an error."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@dataclass(frozen=True)
class DatasetWriter:
    """Adds demonstrations to a dataset folder and keeps its manifests; several processes may share one folder."""

    root: Path
    """Folder of the dataset, created when missing."""
    compression: Compression = "gzip"
    """`gzip` is small, `lzf` is fast."""

    def add(self, demo: Demo) -> Path:
        """Store a demonstration and return its file.

        A demo of the same variation and seed is replaced, so that running a command twice leaves no duplicates.
        """
        if not demo.task_name:
            raise DatasetError("A demonstration without a task name cannot be filed; set `Demo.task_name`.")
        waiting = episode_path(self.root, demo.task_name, demo.variation_number, 0).with_name(
            f".new.{os.getpid()}.{id(demo)}{EPISODE_SUFFIX}"
        )
        write_demo(demo, waiting, self.compression)
        try:
            with locked_manifest(self.root, demo.task_name) as entries:
                number = _episode_number(entries, demo)
                path = episode_path(self.root, demo.task_name, demo.variation_number, number)
                os.replace(waiting, path)
                entries[(demo.variation_number, number)] = _entry(path, self.root, demo, number)
        finally:
            waiting.unlink(missing_ok=True)
        return path


def _episode_number(entries: dict[tuple[int, int], EpisodeEntry], demo: Demo) -> int:
    """Return the number of the same demo when it is stored, else the first after all stored ones."""
    stored = [e for (variation, _), e in entries.items() if variation == demo.variation_number]
    same = [e.episode for e in stored if demo.random_seed is not None and e.random_seed == demo.random_seed]
    return same[0] if same else max((e.episode for e in stored), default=-1) + 1


def _entry(path: Path, root: Path, demo: Demo, number: int) -> EpisodeEntry:
    return EpisodeEntry(
        file=path.relative_to(Path(root) / demo.task_name).as_posix(),
        variation=demo.variation_number,
        episode=number,
        frames=len(demo),
        random_seed=demo.random_seed,
        attempt=demo.attempt,
        num_bytes=path.stat().st_size,
        sha256=file_digest(path),
        instructions=list(demo.instructions),
        versions=dict(demo.versions),
    )
