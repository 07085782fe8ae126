"""Reading of stored demonstrations, without any loss, and summaries of datasets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.layout import ALL_VARIATIONS, check_inside, check_variation, episode_files, manifest_path
from rlbench_pin.datasets.manifest import EpisodeEntry, has_manifest, read_manifest
from rlbench_pin.datasets.trust import Inspector
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.observation import CAMERAS, PRODUCTS, Demo
from rlbench_pin.values import as_flag, as_path, as_record, as_text, as_whole

IMAGE_FIELDS = tuple(f"{camera}_{product}" for camera in CAMERAS for product in PRODUCTS)


def read_demo(
    path: Path,
    fields: Collection[str] | None = None,
    *,
    sha256: str | None = None,
    image_paths: bool = False,
    inspector: Inspector | None = None,
) -> Demo:
    """Read one episode.

    Args:
        path: An episode file.
        fields: Names of `Observation` fields to read; None reads all. `misc` is always read.
        sha256: Expected SHA-256 of the file; None takes it from the manifest of the dataset that contains the file.
        image_paths: Put a reference for `read_image` into each image field and do not read the images.
        inspector: Reads the file first if no manifest lists it. None starts a subprocess for that.

    Raises:
        DatasetError: The file is missing, truncated, damaged, or of another format or version; the message names the file.
    """
    with Episode(path, sha256, inspector) as episode:
        if not as_flag(image_paths, "image_paths"):
            return episode.demo(fields)
        wanted = [name for name in episode.fields if fields is None or name in fields]
        images = [name for name in wanted if name in IMAGE_FIELDS]
        demo = episode.demo([name for name in wanted if name not in IMAGE_FIELDS])
    for index, observation in enumerate(demo):
        for name in images:
            setattr(observation, name, f"{path}#{name}/{index}")
    return demo


def read_image(reference: str) -> np.ndarray:
    """Return the recorded image of a reference from `image_paths=True`.

    Raises:
        DatasetError: The text is not a reference to a stored image.
    """
    path, _, inside = as_text(reference, "reference").rpartition("#")
    name, _, frame = inside.partition("/")
    if not path or name not in IMAGE_FIELDS or not frame.isdigit():
        raise DatasetError(
            f"{reference!r} is not a reference to an image. Give '<file>#<field>/<frame>', as from image_paths=True."
        )
    with Episode(as_path(path, "path")) as episode:
        if name not in episode.fields or int(frame) >= len(episode):
            raise DatasetError(f"'{path}' has no {name} of frame {frame}. Choose from {len(episode)} frames of {episode.fields}.")
        image = episode.series(name, range(int(frame), int(frame) + 1))[0]
    return np.asarray(image)


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
    """Read several episodes of a task: those in its manifest, each checked against its SHA-256.

    Without a manifest, all episode files of the task are read.

    Args:
        root: Folder of the dataset.
        task: Snake-case task name.
        amount: How many, or -1 for all.
        variation: Variation, or -1 for all.
        image_paths: Put a reference for `read_image` into each image field and do not read the images.
        random_selection: Draw at random without replacement; otherwise take them in natural order.
        from_episode_number: First episode in natural order, counted from 0 over all variations. Not for a random selection.
        rng: Draws the random selection; required for one.
        fields: Names of `Observation` fields to read; None reads all.

    Raises:
        DatasetError: There are fewer episodes than requested, or a file is missing or cannot be read.
    """
    root = as_path(root, "root")
    sums = counted_files(root, task, variation)
    files = select(
        list(sums), f"of variation {variation} of '{task}' in '{root}'", amount,
        random_selection=random_selection, from_episode_number=from_episode_number, rng=rng,
    )  # fmt: skip
    with Inspector() as inspector:
        return [counted_demo(path, sums[path], fields, image_paths, inspector) for path in files]


def counted_files(root: Path, task: str, variation: int = ALL_VARIATIONS) -> dict[Path, str | None]:
    """Return the files of the episodes in natural order, each with its expected SHA-256.

    With a manifest these are the listed files, also missing ones; other files are incomplete or foreign. Without a manifest,
    these are all episode files.

    Raises:
        DatasetError: The root, the task or the variation is not stored, or the manifest is damaged.
    """
    if not has_manifest(root, task):
        return dict.fromkeys(episode_files(root, task, variation))
    entries = read_manifest(root, task)
    check_variation(root, task, variation, {entry.variation for entry in entries})
    folder = manifest_path(root, task).parent
    return {folder / e.file: e.sha256 for e in entries if variation in (ALL_VARIATIONS, e.variation)}


def check_there(path: Path) -> None:
    """Raise EpisodeFileError if a listed file does not exist, or is a link out of its dataset."""
    path = as_path(path, "path")
    if not path.is_file():
        raise EpisodeFileError(
            path,
            f"'{path}' is listed in its manifest but does not exist. `rlbench-pin dataset verify` lists all missing files, "
            "`rlbench-pin record --resume` records them again.",
        )
    check_inside(path.parents[3], path)


def counted_demo(
    path: Path,
    sha256: str | None,
    fields: Collection[str] | None,
    image_paths: bool = False,
    inspector: Inspector | None = None,
) -> Demo:
    """Return an episode of `counted_files`, with the checks of `check_there` and `read_demo`."""
    check_there(path)
    return read_demo(path, fields, sha256=sha256, image_paths=image_paths, inspector=inspector)


def select(
    episodes: Sequence[Path],
    what: str,
    amount: int,
    *,
    random_selection: bool,
    from_episode_number: int,
    rng: np.random.Generator | None,
) -> list[Path]:
    """Choose `amount` episodes, -1 for all.

    Args:
        episodes: All episodes in natural order.
        what: Where the episodes are, for errors.
        amount: Number of episodes, or -1 for all.
        random_selection: Draw them without replacement; otherwise take them in order.
        from_episode_number: Index in `episodes` of the first one to take in order.
        rng: Draws the random selection.

    Raises:
        DatasetError: There are too few.
    """
    amount, random_selection = as_whole(amount, "amount, -1 for all,"), as_flag(random_selection, "random_selection")
    if amount < -1:
        raise DatasetError(f"{amount} demos cannot be read. Ask for 0 or more, or for all with -1.")
    first = 0 if random_selection else _checked_first(from_episode_number, len(episodes), what)
    chosen = list(episodes[first:])
    if amount > len(chosen):
        held = f"{len(chosen)} of its {len(episodes)} from episode {first} on" if first else str(len(chosen))
        raise DatasetError(
            f"{amount} demos {what} were asked for, but it has {held}. Ask for fewer, or record more with `rlbench-pin record`."
        )
    if random_selection:
        if rng is None:
            raise DatasetError("A random selection needs a random generator. Pass `rng`, or random_selection=False.")
        as_record(rng, np.random.Generator, "rng")
        chosen = [chosen[i] for i in rng.permutation(len(chosen))]
    return chosen if amount < 0 else chosen[:amount]


def _checked_first(number: int, count: int, what: str) -> int:
    """Return the index of the first episode, or raise DatasetError when there is none."""
    number = as_whole(number, "from_episode_number")
    if number == 0 or 0 < number < count:
        return number
    stored = f"it has {count}. Pass `from_episode_number` from 0 to {count - 1}" if count else "it has none. Record some first"
    raise DatasetError(f"There is no episode {number} {what}: {stored}.")


@dataclass(frozen=True)
class TaskInfo:
    """The stored episodes of one task."""

    task: str
    episodes: int
    variations: tuple[int, ...]
    frames: int
    shortest: int
    """Frames of the shortest episode."""
    median: float
    """Median number of frames."""
    longest: int
    num_bytes: int
    retried: int
    """Episodes that needed more than one try."""
    causes: dict[str, int]
    """Kind of failure -> tries that failed so."""
    images: dict[str, tuple[int, ...]]
    """Image field -> its shape, in the first episode."""
    versions: dict[str, tuple[str, ...]]
    """Library -> its versions."""


def task_info(root: Path, task: str) -> TaskInfo:
    """Return a summary of the stored episodes of a task.

    Raises:
        DatasetError: The manifest is missing, or it or the first file cannot be read.
    """
    entries = read_manifest(root, task)
    if not entries:
        raise DatasetError(f"'{manifest_path(root, task)}' lists no episodes. Record some with `rlbench-pin record {task}`.")
    frames = [e.frames for e in entries]
    return TaskInfo(
        task=task,
        episodes=len(entries),
        variations=tuple(sorted({e.variation for e in entries})),
        frames=sum(frames),
        shortest=min(frames),
        median=float(np.median(frames)),
        longest=max(frames),
        num_bytes=sum(e.num_bytes for e in entries),
        retried=sum(bool(e.failures) or e.attempt > 0 for e in entries),
        causes=dict(Counter(f.split(":")[0] for e in entries for f in e.failures)),
        images=stored_images(manifest_path(root, task).parent / entries[0].file),
        versions=_versions(entries),
    )


def stored_images(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the image fields of an episode file and their shapes."""
    with Episode(path) as episode:
        wanted = [f"{camera}_{product}" for camera in CAMERAS for product in PRODUCTS]
        return {name: episode.shape(name) for name in wanted if name in episode.fields}


def _versions(entries: tuple[EpisodeEntry, ...]) -> dict[str, tuple[str, ...]]:
    names = sorted({name for e in entries for name in e.versions})
    return {name: tuple(sorted({e.versions[name] for e in entries if name in e.versions})) for name in names}
