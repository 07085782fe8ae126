"""What `rlbench-pin dataset info|verify|merge|rerender|seeds|export` takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from rlbench_pin.cli.process.words import (
    Cameras,
    EngineName,
    ExportFormat,
    Files,
    OnlyCameras,
    OnlyTasks,
    Products,
    Size,
    SomeFolders,
)
from rlbench_pin.observation import CAMERAS

Root = tyro.conf.Positional[Annotated[Path, tyro.conf.arg(metavar="FOLDER")]]


@dataclass(frozen=True)
class Info:
    """Count episodes, frames, bytes, retries and versions."""

    root: Root
    """Folder of the dataset."""
    json: bool = False
    """Print JSON for programs."""


@dataclass(frozen=True)
class Verify:
    """Check every file against its SHA-256, and read every value; names the bad ones."""

    root: Root
    """Folder of the dataset."""
    quick: bool = False
    """Compare checksums only."""


@dataclass(frozen=True)
class Merge:
    """Copy the episodes of several datasets into one; refuses what does not go together before it writes anything."""

    out: Path
    """Folder of the result; may hold episodes already."""
    roots: tyro.conf.Positional[SomeFolders] = ()
    """Folders of the datasets."""


@dataclass(frozen=True)
class Rerender:
    """Record demonstrations again from their seeds or their states, with other cameras, sizes and products."""

    source: Root
    """Folder of the dataset (its manifests are enough), or a file with a list of seeds."""
    out: Path
    """Folder of the result; an interrupted run is resumed."""
    tasks: OnlyTasks = ()
    """Only these tasks, with spaces or commas between them."""
    image_size: Size = (128, 128)
    """Width and height of the pictures [px]."""
    cameras: Cameras = CAMERAS
    """Cameras whose pictures are stored."""
    products: Products = ("rgb", "depth", "mask")
    """What each camera delivers, of rgb, depth, mask and point_cloud."""
    workers: int = 1
    """Worker processes; with 0 this process does the work."""
    engine: EngineName = "processes"
    """What does the work: processes of this machine, or a Ray cluster."""
    task_file: Files = ()
    """Your own files of tasks that are not installed; they are used instead of those that the dataset keeps."""
    trust_task_files: bool = False
    """Run the task files that the dataset keeps, where tasks are not installed. Read them first."""


@dataclass(frozen=True)
class Seeds:
    """Write the seeds of a dataset to a small file, from which `rerender` makes it again."""

    root: Root
    """Folder of the dataset."""
    file: tyro.conf.Positional[Path]
    """The file to write."""


@dataclass(frozen=True)
class Export:
    """Write a dataset in the format of another library."""

    format: tyro.conf.Positional[ExportFormat]
    """`lerobot` (LeRobotDataset v3), `robomimic` (one HDF5 file), `rlbench` or `peract` (folders of PNG files), `zarr`."""
    root: Root
    """Folder of the dataset."""
    out: tyro.conf.Positional[Path]
    """The new folder or file."""
    tasks: OnlyTasks = ()
    """Only these tasks, with spaces or commas between them."""
    cameras: OnlyCameras = ()
    """Cameras whose pictures go along; all stored ones when none is named. Folders always get all."""


@dataclass(frozen=True)
class Dataset:
    """Inspect, verify, merge, rerender and export stored demonstrations."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Info, tyro.conf.subcommand("info")]
        | Annotated[Verify, tyro.conf.subcommand("verify")]
        | Annotated[Merge, tyro.conf.subcommand("merge")]
        | Annotated[Rerender, tyro.conf.subcommand("rerender")]
        | Annotated[Seeds, tyro.conf.subcommand("seeds")]
        | Annotated[Export, tyro.conf.subcommand("export")]
    ] = field()
    """What to do."""
