"""Formats of other libraries, one module each: exporters, and the reader of RLBench-style folders."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

from rlbench_pin.datasets.formats.common import StoredEpisode, stored_episodes
from rlbench_pin.datasets.formats.rlbench import export_rlbench, folder_demos, folder_descriptions, folder_episodes, read_folder
from rlbench_pin.datasets.formats.robomimic import export_robomimic
from rlbench_pin.errors import MissingExtra
from rlbench_pin.values import as_choice, as_function, as_names

__all__ = [
    "ExportFormat",
    "StoredEpisode",
    "export_dataset",
    "export_rlbench",
    "export_robomimic",
    "find_exporter",
    "folder_demos",
    "folder_descriptions",
    "folder_episodes",
    "read_folder",
    "stored_episodes",
]

ExportFormat = Literal["lerobot", "robomimic", "rlbench", "peract", "zarr"]
"""`lerobot` (LeRobotDataset v3), `robomimic` (one HDF5 file), `rlbench` and `peract` (folders of PNG files), `zarr`."""

# Format -> module, function, its options, whether it exports chosen cameras, extra that brings the library it needs.
_EXPORTERS: dict[str, tuple[str, str, dict[str, str], bool, str]] = {
    "lerobot": ("lerobot", "export_lerobot", {}, True, "lerobot"),
    "robomimic": ("robomimic", "export_robomimic", {}, True, ""),
    "rlbench": ("rlbench", "export_rlbench", {"layout": "upstream"}, False, ""),
    "peract": ("rlbench", "export_rlbench", {"layout": "peract"}, False, ""),
    "zarr": ("zarr_buffer", "export_zarr", {}, True, "zarr"),
}


def export_dataset(
    name: ExportFormat,
    root: Path,
    out: Path,
    *,
    tasks: Sequence[str] = (),
    cameras: Sequence[str] = (),
    on_episode: Callable[[int], None] | None = None,
) -> Path:
    """Write the episodes of a dataset in the format of another library, and return the path of the result.

    Args:
        name: The format.
        root: Folder of the dataset.
        out: The new folder or file.
        tasks: Only these tasks; all if empty.
        cameras: Cameras whose images are exported; all stored ones if empty. RLBench-style folders always get all.
        on_episode: Called with the number of episodes written so far.

    Raises:
        MissingExtra: The library that the format needs is not installed.
        DatasetError: Something is missing or damaged, or `out` exists.
        StorageError: The disk cannot be written to.
    """
    as_function(on_episode, "on_episode")
    return find_exporter(name, as_names(cameras, "cameras"))(root, out, tasks=tasks, on_episode=on_episode)


def find_exporter(name: ExportFormat, cameras: tuple[str, ...] = ()) -> Callable[..., Path]:
    """Return the function that writes a format, and import its library.

    Args:
        name: The format.
        cameras: Cameras whose images are exported; all stored ones if empty. RLBench-style folders always get all.

    Raises:
        MissingExtra: The library that the format needs is not installed.
        UnknownName: There is no such format.
    """
    as_choice(name, "format", _EXPORTERS)
    module, function, options, has_cameras, extra = _EXPORTERS[name]
    try:
        export: Callable[..., Path] = getattr(importlib.import_module(f"{__name__}.{module}"), function)
    except ImportError as error:
        raise MissingExtra(f"The export to '{name}'", error.name or extra, extra) from error
    return partial(export, cameras=cameras, **options) if has_cameras else partial(export, **options)
