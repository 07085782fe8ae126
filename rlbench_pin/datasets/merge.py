"""Merge of several datasets into one; all checks come before the first write."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rlbench_pin.datasets.layout import episode_file, manifest_path, stored_tasks
from rlbench_pin.datasets.manifest import EpisodeEntry, digest, fold_journal, has_manifest, journal_path, read_manifest
from rlbench_pin.datasets.reader import check_there, stored_images
from rlbench_pin.datasets.storage import hold, remove_leftovers
from rlbench_pin.datasets.task_copy import check_alike, copy_kept
from rlbench_pin.datasets.writer import DatasetWriter
from rlbench_pin.errors import DatasetConflict, DatasetError, EpisodeFileError
from rlbench_pin.values import as_function, as_path, items_of


@dataclass(frozen=True)
class Move:
    """One episode to be copied."""

    task: str
    source: Path
    entry: EpisodeEntry
    """How it will be listed."""
    root: Path
    """The dataset that it comes from."""


_Known = dict[tuple[int, int | str], tuple[EpisodeEntry, Path]]
"""Variation and seed of an episode -> its entry and its file."""


def merge_datasets(roots: Sequence[Path], out: Path, on_episode: Callable[[Move], None] | None = None) -> tuple[Move, ...]:
    """Copy the episodes of several datasets into one. The result may exist; its own episodes keep their numbers.

    An episode is not copied if the result has a byte-identical one. A repeated merge deletes incomplete files of a killed merge
    and completes it.

    Raises:
        DatasetConflict: Two episodes of one seed differ, images differ in kind or size, a task has another version, or another
            process writes to the result. Nothing was written.
        EpisodeFileError: A file is missing or differs from its manifest.
        StorageError: The disk cannot be written to. All episodes stored before are complete; merge again for the rest.
    """
    out = as_path(out, "out")
    as_function(on_episode, "on_episode")
    if not plan_merge(roots, out) and not _is_unfinished(out):
        return ()
    with hold(out):
        remove_leftovers(out)
        moves = plan_merge(roots, out)  # again: a recording may have ended in between
        writer = DatasetWriter(out)
        for task, root in {move.task: move.root for move in reversed(moves)}.items():
            copy_kept(root, task, out)
        for move in moves:
            writer.put(move.task, _checked_bytes(move), move.entry)
            if on_episode is not None:
                on_episode(move)
        for task in stored_tasks(out):
            fold_journal(out, task)
    return moves


def _is_unfinished(out: Path) -> bool:
    """Whether a killed process left a journal or an incomplete file in a dataset."""
    if not out.is_dir():
        return False
    return any(journal_path(manifest_path(out, task)).exists() for task in stored_tasks(out)) or any(out.rglob(".*.part"))


def plan_merge(roots: Sequence[Path], out: Path) -> tuple[Move, ...]:
    """Check that the datasets are compatible, and return the episodes that `merge_datasets` copies."""
    roots = [as_path(root, "root") for root in items_of(roots)]
    if not roots:
        raise DatasetError("No dataset was named to merge. Name at least one folder.")
    out = as_path(out, "out")
    moves: list[Move] = []
    tasks = sorted({task for root in roots for task in stored_tasks(root)})
    for task in tasks:
        moves += _plan_task(roots, out, task)
    return tuple(moves)


def _plan_task(roots: Sequence[Path], out: Path, task: str) -> list[Move]:
    moves: list[Move] = []
    known: _Known = {}
    images: tuple[dict[str, tuple[int, ...]], Path] | None = None
    stored = [root for root in (out, *roots) if has_manifest(root, task)]
    check_alike([root for root in stored if read_manifest(root, task)], task)
    _check_versions(stored, task)
    for root in stored:
        entries = read_manifest(root, task)
        for entry in entries:
            source = manifest_path(root, task).parent / entry.file
            check_there(source)
            if root is out:
                known[_identity(entry)] = (entry, source)
            elif not _is_known(known, entry, source):
                number = 1 + max((e.episode for e, _ in known.values() if e.variation == entry.variation), default=-1)
                entry = replace(entry, episode=number, file=episode_file(entry.variation, number))
                known[_identity(entry)] = (entry, source)
                moves.append(Move(task, source, entry, root))
        if entries:
            images = _same_images(images, manifest_path(root, task).parent / entries[0].file)
    return moves


def _check_versions(roots: Sequence[Path], task: str) -> None:
    found = {entry.task_version: root for root in roots for entry in read_manifest(root, task)}
    if len(found) > 1:
        listed = ", ".join(f"version {version} in '{root}'" for version, root in sorted(found.items()))
        raise DatasetConflict(f"The task '{task}' has different versions: {listed}. Record the older episodes again.")


def _identity(entry: EpisodeEntry) -> tuple[int, int | str]:
    """Return variation and seed of an episode; an episode without a seed is identified by its SHA-256."""
    return entry.variation, entry.sha256 if entry.random_seed is None else entry.random_seed


def _is_known(known: _Known, entry: EpisodeEntry, source: Path) -> bool:
    same = known.get(_identity(entry))
    if same is None:
        return False
    if same[0].sha256 == entry.sha256:
        return True
    raise DatasetConflict(
        f"'{source}' and '{same[1]}' both have variation {entry.variation} and seed {entry.random_seed}, but differ. "
        "Leave one of them out, or rerender one dataset like the other."
    )


def _same_images(before: tuple[dict[str, tuple[int, ...]], Path] | None, path: Path) -> tuple[dict[str, tuple[int, ...]], Path]:
    shapes = stored_images(path)
    if before is not None and before[0] != shapes:
        raise DatasetConflict(
            f"'{path}' has images of {shapes}, '{before[1]}' of {before[0]}. "
            "Rerender one dataset with `rlbench-pin dataset rerender` first."
        )
    return shapes, path


def _checked_bytes(move: Move) -> bytes:
    data = move.source.read_bytes()
    if digest(data) != move.entry.sha256:
        raise EpisodeFileError(
            move.source, f"'{move.source}' differs from its manifest: the SHA-256 is another one. Record it again first."
        )
    return data
