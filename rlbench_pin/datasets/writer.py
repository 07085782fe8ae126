"""Writing of demonstrations: each to a temporary file that is renamed when complete, with a checksum in the manifest."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import h5py

from rlbench_pin.datasets.layout import check_inside, episode_file, episode_path, manifest_path
from rlbench_pin.datasets.manifest import ONLY_ARM, EpisodeEntry, append_entry, digest, locked_manifest
from rlbench_pin.datasets.series import to_json, write_series
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import FIELDS, Demo
from rlbench_pin.values import LARGEST_SEED, as_choice, as_names, as_path, as_record, as_seed, as_text, as_whole

FORMAT = "rlbench_pin.episode"
VERSION = 1
DESCRIPTIONS = "descriptions"
"""Key of the instructions in `misc`."""


Compression = Literal["gzip", "lzf"]


def encode_demo(demo: Demo, compression: Compression = "gzip") -> bytes:
    """Return one demonstration as the bytes of an episode file; equal demonstrations give equal bytes.

    Args:
        demo: The demonstration.
        compression: `gzip` is small, `lzf` is fast; both keep every bit.

    Raises:
        DatasetError: The demonstration is empty or has a value that cannot be stored.
    """
    _check_demo(demo)
    as_choice(compression, "compression", get_args(Compression))
    if len(demo) == 0:
        raise DatasetError("A demonstration without observations cannot be written. Record at least one observation.")
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        _write_head(file, demo)
        try:
            _write_observations(file, demo, compression)
            _write_state(file, demo, compression)
        except TypeError as error:
            problem = f"The demonstration of '{demo.task_name}' cannot be written: {error}"
            raise DatasetError(f"{problem}. Change that value.") from error
    return buffer.getvalue()


def _check_demo(demo: Demo) -> None:
    """Raise InvalidValue unless it is a demonstration whose numbers fit into an episode file."""
    as_record(demo, Demo, "demo")
    if demo.seed is not None:
        as_seed(demo.seed, "Demo.random_seed")
    as_whole(demo.task_version, "Demo.task_version", least=1, most=LARGEST_SEED)
    for name in ("variation_number", "attempt"):
        as_whole(getattr(demo, name), f"Demo.{name}", least=0, most=LARGEST_SEED)
    if demo.num_reset_attempts is not None:
        as_whole(demo.num_reset_attempts, "Demo.num_reset_attempts", least=0, most=LARGEST_SEED)
    as_text(demo.task_name, "Demo.task_name")
    as_names(demo.instructions, "Demo.instructions")


def write_demo(demo: Demo, path: Path, compression: Compression = "gzip") -> Path:
    """Write one demonstration to one file, atomically.

    Args:
        demo: The demonstration.
        path: The file; an existing one is replaced.
        compression: `gzip` is small, `lzf` is fast; both keep every bit.

    Raises:
        DatasetError: The demonstration is empty or has a value that cannot be stored.
        StorageError: The disk cannot be written to.
    """
    return write_whole(as_path(path, "path"), encode_demo(demo, compression))


def _write_head(file: h5py.File, demo: Demo) -> None:
    file.attrs["format"] = FORMAT
    file.attrs["version"] = VERSION
    file.attrs["frames"] = len(demo)
    file.attrs["task"] = demo.task_name
    file.attrs["task_version"] = demo.task_version
    file.attrs["variation"] = demo.variation_number
    file.attrs["attempt"] = demo.attempt
    if demo.robot:
        file.attrs["robot"], file.attrs["joint_names"] = demo.robot, to_json(list(demo.joint_names))
    if demo.factors:
        file.attrs["factors"] = demo.factors
    file.attrs["instructions"] = to_json(list(demo.instructions))
    file.attrs["versions"] = to_json(dict(demo.versions))
    if demo.seed is not None:
        file.attrs["random_seed"] = demo.seed
    elif demo.random_seed is not None:
        file.attrs["random_state"] = to_json(demo.random_seed)
    if demo.num_reset_attempts is not None:
        file.attrs["num_reset_attempts"] = demo.num_reset_attempts


def _write_observations(file: h5py.File, demo: Demo, compression: str) -> None:
    group = file.create_group("observations")
    for name in (*FIELDS, *_further_fields(demo)):
        write_series(group, name, [getattr(obs, name, None) for obs in demo], compression)
    misc = file.create_group("misc")
    keys = {key for obs in demo for key in obs.misc}
    if all(obs.misc.get(DESCRIPTIONS) == list(demo.instructions) for obs in demo):
        file.attrs[DESCRIPTIONS] = True  # every frame has the instructions
        keys.remove(DESCRIPTIONS)
    for key in _checked(keys):
        write_series(misc, key, [obs.misc.get(key) for obs in demo], compression)


def _further_fields(demo: Demo) -> list[str]:
    """Return the attributes that are not declared fields: images of extra cameras."""
    return _checked({name for obs in demo for name in vars(obs)} - {*FIELDS, "misc"})


def _checked(names: Iterable[str]) -> list[str]:
    for name in (names := sorted(names)):
        if "/" in name or "@" in name or name in ("", "."):
            raise TypeError(f"the key {name!r} is empty or has a '/' or '@' in it")
    return names


def _write_state(file: h5py.File, demo: Demo, compression: str) -> None:
    if demo.state is None:
        return
    group = file.create_group("state")
    for index, (name, array) in enumerate(sorted(demo.state.items())):
        write_series(group, f"array{index}", [array], compression)
        group[f"array{index}"].attrs["name"] = name


@dataclass(frozen=True)
class DatasetWriter:
    """Adds demonstrations to a dataset folder and keeps its manifests; several processes may share one folder."""

    root: Path
    """Folder of the dataset, created when missing."""
    compression: Compression = "gzip"
    """`gzip` is small, `lzf` is fast."""

    def __post_init__(self) -> None:
        """Raise InvalidValue or UnknownName for an invalid folder or compression."""
        object.__setattr__(self, "root", as_path(self.root, "DatasetWriter.root"))
        as_choice(self.compression, "compression", get_args(Compression))

    def add(self, demo: Demo) -> Path:
        """Store a demonstration and return its file.

        It replaces a stored demonstration of the same variation and seed, so that a repeated command makes no duplicates.
        """
        if not as_record(demo, Demo, "demo").task_name:
            raise DatasetError("A demonstration without a task name cannot be stored. Set `Demo.task_name`.")
        data = encode_demo(demo, self.compression)
        with locked_manifest(self.root, demo.task_name) as entries:
            number = _episode_number(entries, demo)
            path = episode_path(self.root, demo.task_name, demo.variation_number, number)
            check_inside(self.root, path.parent)
            write_whole(path, data)
            entries[(demo.variation_number, number)] = episode_entry(demo, data, number)
        return path

    def put(self, task: str, data: bytes, entry: EpisodeEntry) -> Path:
        """Store an encoded episode under the number in its entry, and return its file.

        The file is complete on the disk before the manifest lists it. Call `fold_journal` after the last episode.

        Raises:
            DatasetError: The entry names another file than that of its episode, or a link leads out of the dataset.
            StorageError: The disk cannot be written to; the episode is not listed.
        """
        as_record(data, bytes, "data")
        as_record(entry, EpisodeEntry, "entry").check(manifest_path(self.root, task))
        path = episode_path(self.root, task, entry.variation, entry.episode)
        check_inside(self.root, path.parent)
        write_whole(path, data)
        append_entry(self.root, task, entry)
        return path


def episode_entry(demo: Demo, data: bytes, number: int, failures: Sequence[str] = ()) -> EpisodeEntry:
    """Return the manifest entry of a demonstration encoded as `data`."""
    _check_demo(demo)
    number, data = as_whole(number, "number", least=0), as_record(data, bytes, "data")
    failures = as_names(failures, "failures")
    return EpisodeEntry(
        file=episode_file(demo.variation_number, number),
        variation=demo.variation_number,
        episode=number,
        frames=len(demo),
        random_seed=demo.seed,
        attempt=demo.attempt,
        num_bytes=len(data),
        sha256=digest(data),
        instructions=list(demo.instructions),
        versions=dict(demo.versions),
        failures=list(failures),
        robot=demo.robot or ONLY_ARM,
        task_version=demo.task_version,
    )


def _episode_number(entries: dict[tuple[int, int], EpisodeEntry], demo: Demo) -> int:
    """Return the number of the same demonstration if it is stored, else the next free number."""
    stored = [e for (variation, _), e in entries.items() if variation == demo.variation_number]
    same = [e.episode for e in stored if demo.seed is not None and e.random_seed == demo.seed]
    return same[0] if same else max((e.episode for e in stored), default=-1) + 1
