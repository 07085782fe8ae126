"""Verification of a dataset: SHA-256, manifest entry and structure of every file."""

from __future__ import annotations

from pathlib import Path

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.layout import check_inside, episode_files, manifest_path
from rlbench_pin.datasets.manifest import EpisodeEntry, file_digest, read_manifest
from rlbench_pin.datasets.task_copy import kept_faults
from rlbench_pin.datasets.trust import altered
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.values import as_flag


def task_faults(root: Path, task: str, *, structure: bool = True) -> list[DatasetError]:
    """Return the faults of the stored episodes and task files of a task, one error per file; empty if there are none.

    Args:
        root: Folder of the dataset.
        task: Task name.
        structure: Also open every file and read every value. False compares only checksums.
    """
    structure = as_flag(structure, "structure")
    manifest = manifest_path(root, task)
    try:
        entries = read_manifest(root, task)
        files = episode_files(root, task)
    except DatasetError as error:
        return [error]
    faults = [fault for entry in entries if (fault := _fault(manifest.parent, entry, task, structure)) is not None]
    listed = {manifest.parent / entry.file for entry in entries}
    faults += kept_faults(root, task)
    return faults + [
        EpisodeFileError(path, f"'{path}' is not listed in {manifest}. Delete it, or record again with `--resume`.")
        for path in files
        if path not in listed
    ]


def verify_task(root: Path, task: str, *, structure: bool = False) -> None:
    """Check every stored episode of a task against its manifest.

    Raises:
        DatasetError: A file is missing, altered or not listed; the message names the first one.
    """
    faults = task_faults(root, task, structure=structure)
    if faults:
        raise faults[0]


def _fault(folder: Path, entry: EpisodeEntry, task: str, structure: bool) -> DatasetError | None:
    path = folder / entry.file
    try:
        if not path.is_file():
            return EpisodeFileError(path, f"'{path}' is listed in the manifest but does not exist. Record it again.")
        check_inside(folder.parent, path)
        if path.stat().st_size != entry.num_bytes or file_digest(path) != entry.sha256:
            return altered(path)
        if structure:
            check_structure(path, entry, task)
    except OSError as error:
        return EpisodeFileError(path, f"'{path}' cannot be read: {error}. Check the disk and the permissions.")
    except DatasetError as error:
        return error
    return None


def check_structure(path: Path, entry: EpisodeEntry, task: str) -> None:
    """Compare the SHA-256 of a file, read all its values, and compare them with its entry in the manifest.

    Raises:
        EpisodeFileError: A value cannot be read or differs; the message names the file.
    """
    with Episode(path, entry.sha256) as episode:
        demo = episode.demo()
    listed = (task, entry.variation, entry.frames, entry.random_seed, entry.attempt)
    found = (demo.task_name, demo.variation_number, len(demo), demo.seed, demo.attempt)
    if listed != found:
        raise EpisodeFileError(
            path, f"'{path}' has (task, variation, frames, seed, attempt) {found}, its manifest {listed}. Record it again."
        )
