"""Reading demonstrations back, equal to what was written."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from rlbench_pin.datasets.layout import episode_files, episode_number
from rlbench_pin.datasets.series import from_json, read_series
from rlbench_pin.datasets.writer import FIELDS, FORMAT, VERSION
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import Demo, Observation


def read_demo(path: Path, fields: Collection[str] | None = None) -> Demo:
    """Read one episode.

    Args:
        path: An episode file.
        fields: Names of `Observation` fields to read; None reads all. `misc` always comes along.

    Raises:
        DatasetError: The file is missing, truncated, damaged, or of another format or version; names the file.
    """
    path = Path(path)
    if not path.is_file():
        raise DatasetError(f"The episode '{path}' does not exist.")
    try:
        with h5py.File(path, "r") as file:
            _check_version(file, path)
            return _read(file, fields)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        if isinstance(error, DatasetError):
            raise
        raise DatasetError(f"The episode '{path}' is truncated or damaged ({error}). Delete it and record it again.") from error


def stored_demos(
    root: Path | str,
    task: str,
    amount: int,
    variation: int,
    *,
    image_paths: bool = False,
    random_selection: bool = True,
    from_episode_number: int = 0,
    rng: np.random.Generator | None = None,
    fields: Collection[str] | None = None,
) -> list[Demo]:
    """Read several episodes of a task.

    Args:
        root: Folder of the dataset.
        task: Snake-case task name.
        amount: How many, or -1 for all.
        variation: Variation, or -1 for all.
        image_paths: Refused: pictures lie inside the episode files.
        random_selection: Pick at random, without repeats; otherwise in natural order.
        from_episode_number: First episode when taken in order.
        rng: Draws the random selection; needed when there is one.
        fields: Names of `Observation` fields to read; None reads all.

    Raises:
        DatasetError: More are asked for than are stored, or a file cannot be read.
    """
    if image_paths:
        raise DatasetError("Pictures lie inside the episode files, so there are no paths to them. Use image_paths=False.")
    files = list(episode_files(Path(root), task, variation))
    if not random_selection:
        files = [path for path in files if episode_number(path) >= from_episode_number]
    if amount > len(files):
        raise DatasetError(
            f"{amount} demos of '{task}' were asked for, but '{root}' holds {len(files)} of variation {variation}. "
            "Ask for fewer, or record more with `rlbench-pin demo`."
        )
    count = len(files) if amount < 0 else amount
    if random_selection:
        if rng is None:
            raise DatasetError("A random selection needs a generator: pass `rng`, or random_selection=False.")
        files = [files[i] for i in rng.permutation(len(files))]
    return [read_demo(path, fields) for path in files[:count]]


def _check_version(file: h5py.File, path: Path) -> None:
    if file.attrs.get("format") != FORMAT:
        raise DatasetError(f"'{path}' is an HDF5 file, but not an episode of this package.")
    version = int(file.attrs.get("version", -1))
    if version != VERSION:
        raise DatasetError(f"The episode '{path}' has format version {version}; this package reads version {VERSION}.")


def _read(file: h5py.File, fields: Collection[str] | None) -> Demo:
    attrs = file.attrs
    length = int(attrs["frames"])
    return Demo(
        _read_observations(file, length, FIELDS if fields is None else fields),
        random_seed=_optional_int(attrs, "random_seed"),
        num_reset_attempts=_optional_int(attrs, "num_reset_attempts"),
        variation_number=int(attrs["variation"]),
        instructions=from_json(attrs["instructions"]),
        state=_read_state(file),
        versions=from_json(attrs["versions"]),
        attempt=int(attrs["attempt"]),
        task_name=str(attrs["task"]),
    )


def _read_observations(file: h5py.File, length: int, fields: Collection[str]) -> list[Observation]:
    group, misc = file["observations"], file["misc"]
    columns = {name: read_series(group, name, length) for name in FIELDS if name in group and name in fields}
    extras = {key: read_series(misc, key, length) for key in misc if "@" not in key}
    frames: list[dict[str, Any]] = [{name: values[i] for name, values in columns.items()} for i in range(length)]
    return [
        Observation(**frame, misc={key: values[i] for key, values in extras.items() if values[i] is not None})
        for i, frame in enumerate(frames)
    ]


def _read_state(file: h5py.File) -> dict[str, np.ndarray] | None:
    if "state" not in file:
        return None
    group = file["state"]
    names = sorted((name for name in group if "@" not in name), key=lambda n: int(n.removeprefix("array")))
    return {str(group[name].attrs["name"]): read_series(group, name, 1)[0] for name in names}


def _optional_int(attrs: h5py.AttributeManager, name: str) -> int | None:
    return int(attrs[name]) if name in attrs else None
