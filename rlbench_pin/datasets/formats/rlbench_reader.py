"""Reading RLBench-style folders, whichever program wrote them, in both layouts."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.datasets.formats.rlbench_folders import DESCRIPTIONS_FILE, LOW_DIM_FILE, VARIATION_FILE
from rlbench_pin.datasets.formats.rlbench_pickle import PickledDemo, load
from rlbench_pin.datasets.formats.rlbench_pictures import decode_depth, decode_mask, read_png
from rlbench_pin.datasets.layout import ALL_VARIATIONS, checked_task_name
from rlbench_pin.datasets.reader import select
from rlbench_pin.errors import EpisodeFileError, shown
from rlbench_pin.observation import CAMERAS, FIELDS, Demo, Observation
from rlbench_pin.values import as_path, as_whole

_EPISODE = re.compile(r"episode(\d+)")
_VARIATION = re.compile(r"variation(\d+)")
_COUNTED = ("rgb", "depth")
_DECODE: dict[str, Callable[[np.ndarray], np.ndarray]] = {"rgb": np.array, "depth": decode_depth, "mask": decode_mask}
_DECODERS = {f"{camera}_{product}": decode for camera in CAMERAS for product, decode in _DECODE.items()}


def folder_episodes(root: Path, task: str, variation: int = ALL_VARIATIONS) -> list[Path]:
    """Return the episode folders of one variation, or of all (-1), in natural order; none when there are none."""
    variation = as_whole(variation, "variation, -1 for all,")
    task_folder = as_path(root, "root") / checked_task_name(task)
    parents = sorted((p for p in task_folder.glob("variation*") if _VARIATION.fullmatch(p.name)), key=lambda p: int(p.name[9:]))
    if variation != ALL_VARIATIONS:
        parents = [p for p in parents if p.name == f"variation{variation}"]
    found = [folder for parent in parents for folder in _episodes(parent)]
    together = _episodes(task_folder / "all_variations")
    if variation != ALL_VARIATIONS:
        together = [folder for folder in together if _variation_of(folder) == variation]
    return found + together


def folder_demos(
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
        image_paths: Put paths of PNG files into picture fields and leave the files unread.
        random_selection: Pick at random, without repeats; otherwise in natural order.
        from_episode_number: First episode when taken in order, counted from 0 through all that there are, also over variations.
        rng: Draws the random selection; needed when there is one.
        fields: Names of `Observation` fields to read; None reads all.

    Raises:
        DatasetError: There are too few, or a file is missing or broken.
    """
    episodes = folder_episodes(as_path(root, "root"), task, variation)
    what = f"of variation {variation} of '{task}' in '{root}'"
    chosen = select(episodes, what, amount, random_selection=random_selection, from_episode_number=from_episode_number, rng=rng)
    return [read_folder(path, fields, image_paths=image_paths) for path in chosen]


def read_folder(path: Path, fields: Collection[str] | None = None, *, image_paths: bool = False) -> Demo:
    """Read one episode folder; see `folder_demos`."""
    path = as_path(path, "path")
    pickled = load(path / LOW_DIM_FILE)
    observations = getattr(pickled, "_observations", pickled)
    if not isinstance(observations, list) or not observations:
        raise EpisodeFileError(path, f"'{path / LOW_DIM_FILE}' holds no list of observations.")
    frames = [_observation(o, path) for o in observations]
    _check_counts(path, len(frames))
    for name in FIELDS:
        if fields is not None and name not in fields:
            for frame in frames:
                setattr(frame, name, None)
        elif name in _DECODERS and (path / name).is_dir():
            _add_pictures(path / name, frames, image_paths)
    variation = _variation_of(path)
    if variation is None:
        variation = _variation_in(frames[0], path)
    for frame in frames:
        frame.misc.setdefault("variation_index", variation)
    return _demo(pickled, frames, variation, path)


def _demo(pickled: Any, frames: list[Observation], variation: int, path: Path) -> Demo:
    known = vars(pickled) if isinstance(pickled, PickledDemo) else {}
    seed, attempts, attempt = (known.get(name) for name in ("random_seed", "num_reset_attempts", "attempt"))
    return Demo(
        frames,
        random_seed=seed if isinstance(seed, int | tuple) else None,
        num_reset_attempts=attempts if isinstance(attempts, int) else None,
        attempt=attempt if isinstance(attempt, int) else 0,
        state=_arrays(known.get("state")),
        variation_number=variation,
        instructions=folder_descriptions(path),
        task_name=path.parents[2].name,
    )


def _arrays(state: object) -> dict[str, np.ndarray] | None:
    """Return a snapshot of a world, where a program pickled one, otherwise None."""
    whole = isinstance(state, dict) and all(isinstance(value, np.ndarray) for value in state.values())
    return state if whole else None  # type: ignore[return-value]


def folder_descriptions(path: Path) -> tuple[str, ...]:
    """Return the sentences of an episode; a file that holds something else, as some old ones do, counts as none."""
    path = as_path(path, "path")
    for folder in (path, path.parent.parent):
        if (folder / DESCRIPTIONS_FILE).is_file():
            found = load(folder / DESCRIPTIONS_FILE)
            return tuple(found) if isinstance(found, list) and all(isinstance(s, str) for s in found) else ()
    return ()


def _variation_of(path: Path) -> int | None:
    """Return the variation of a folder, given by its name or by the file inside."""
    match = _VARIATION.fullmatch(path.parents[1].name)
    if match:
        return int(match[1])
    if not (path / VARIATION_FILE).is_file():
        return None
    found = load(path / VARIATION_FILE)
    return found if isinstance(found, int) else None


def _variation_in(frame: Observation, path: Path) -> int:
    """Return the variation that the first frame names, 0 where it names none."""
    found = frame.misc.get("variation_index", 0)
    if not isinstance(found, int | np.integer):
        raise EpisodeFileError(path, f"'{path / LOW_DIM_FILE}' names the variation {shown(found)}, which is no whole number.")
    return int(found)


def _observation(pickled: Any, path: Path) -> Observation:
    known = getattr(pickled, "__dict__", None)
    if not isinstance(known, dict):
        raise EpisodeFileError(path, f"'{path / LOW_DIM_FILE}' holds a {type(pickled).__name__} where an observation belongs.")
    misc = known.get("misc")
    values = {name: known.get(name) for name in FIELDS}
    observation = Observation(**values, misc=dict(misc) if isinstance(misc, dict) else {})
    if known.get("ignore_collisions") is not None:
        observation.ignore_collisions = bool(np.all(known["ignore_collisions"]))
    return observation


def _check_counts(path: Path, frames: int) -> None:
    for camera in CAMERAS:
        for product in _COUNTED:
            folder = path / f"{camera}_{product}"
            if folder.is_dir() and (count := len(list(folder.glob("*.png")))) != frames:
                raise EpisodeFileError(path, f"Broken dataset: '{folder}' holds {count} pictures for {frames} frames.")


def _add_pictures(folder: Path, frames: list[Observation], image_paths: bool) -> None:
    for index, frame in enumerate(frames):
        file = folder / f"{index}.png"
        setattr(frame, folder.name, str(file) if image_paths else _DECODERS[folder.name](read_png(file)))


def _episodes(parent: Path) -> list[Path]:
    folders = [p for p in (parent / "episodes").glob("episode*") if _EPISODE.fullmatch(p.name) and (p / LOW_DIM_FILE).is_file()]
    return sorted(folders, key=_number)


def _number(path: Path) -> int:
    match = _EPISODE.fullmatch(path.name)
    return int(match[1]) if match else 0
