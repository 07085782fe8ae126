"""RLBench-style folders: PNG files for images, a pickled list of observations for the rest; export and reading.

Two layouts: `upstream`, `<root>/<task>/variation<k>/episodes/episode<j>`, and `peract`, `<root>/<task>/all_variations/episodes/
episode<j>` with number and sentences of the variation inside each episode.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from PIL import Image, UnidentifiedImageError

from rlbench_pin.datasets.formats.common import OnEpisode, StoredEpisode, new_folder, opened, stored_episodes
from rlbench_pin.datasets.formats.rlbench_pickle import PickledDemo, PickledObservation, dump, load
from rlbench_pin.datasets.layout import ALL_VARIATIONS, checked_task_name
from rlbench_pin.datasets.reader import select
from rlbench_pin.errors import DatasetError, EpisodeFileError, shown
from rlbench_pin.observation import CAMERAS, FIELDS, IN_METRES, Demo, Observation
from rlbench_pin.values import as_choice, as_function, as_path, as_whole

DEPTH_STEPS = 2**24 - 1
"""Depth 0..1 is stored in so many steps: 0.3 micrometres of 4.5 m."""
Layout = Literal["upstream", "peract"]
LOW_DIM_FILE, DESCRIPTIONS_FILE, VARIATION_FILE = "low_dim_obs.pkl", "variation_descriptions.pkl", "variation_number.pkl"
PRODUCTS = ("rgb", "depth", "mask")
_IMAGES = tuple(f"{camera}_{product}" for camera in CAMERAS for product in (*PRODUCTS, "point_cloud"))
_EPISODE = re.compile(r"episode(\d+)")
_VARIATION = re.compile(r"variation(\d+)")
_COUNTED = ("rgb", "depth")


def is_in_metres(depth: np.ndarray, misc: Mapping[str, Any], camera: str) -> bool:
    """Whether depth is in [m], as `misc` says or a value above 1 shows; otherwise it is 0..1 between the clipping planes."""
    return bool(misc.get(f"{camera}_{IN_METRES}", np.max(depth) > 1.0))


def encode_depth(depth: np.ndarray) -> np.ndarray:
    """Return depth (h, w) in 0..1 as three bytes (h, w, 3), the most significant one first."""
    if not np.all((depth >= 0.0) & (depth <= 1.0)):
        raise DatasetError("Depth must be in 0..1 for an image. Record with depth_in_meters=False.")
    steps = np.rint(depth.astype(np.float64) * DEPTH_STEPS).astype(np.uint32)
    return np.stack([steps >> 16, steps >> 8 & 255, steps & 255], axis=-1).astype(np.uint8)


def decode_depth(image: np.ndarray) -> np.ndarray:
    """Return depth (h, w) in 0..1, float32."""
    r, g, b = (image[..., i].astype(np.uint32) for i in range(3))
    return ((r << 16 | g << 8 | b) / DEPTH_STEPS).astype(np.float32)


def encode_mask(mask: np.ndarray) -> np.ndarray:
    """Return ids (h, w) as three bytes (h, w, 3), the least significant one first."""
    ids = mask.astype(np.int64)
    if np.any((ids < 0) | (ids >= 2**24)):
        raise DatasetError("Ids of a mask must be in 0..2^24 - 1 for an image. Use smaller ids.")
    return np.stack([ids & 255, ids >> 8 & 255, ids >> 16], axis=-1).astype(np.uint8)


def spread_bytes(mask: np.ndarray) -> np.ndarray:
    """Return a mask over three channels (h, w, 3), floats in 0..1 or whole numbers in 0..255, as bytes."""
    return np.rint(mask * 255.0 if mask.dtype.kind == "f" else mask).astype(np.uint8)


def decode_mask(image: np.ndarray) -> np.ndarray:
    """Return ids (h, w), int32."""
    r, g, b = (image[..., i].astype(np.int32) for i in range(3))
    return r | g << 8 | b << 16


def write_png(path: Path, image: np.ndarray) -> None:
    """Write (h, w, 3) bytes."""
    Image.fromarray(np.ascontiguousarray(image)).save(path, compress_level=6)


def read_png(path: Path) -> np.ndarray:
    """Read (h, w, 3) bytes.

    Raises:
        EpisodeFileError: The file is missing or damaged.
    """
    try:
        with Image.open(path) as image:
            return np.array(image.convert("RGB"))
    except (OSError, UnidentifiedImageError, SyntaxError, Image.DecompressionBombError) as error:
        raise EpisodeFileError(path, f"The image '{path}' is missing or damaged ({error}). Restore it.") from error


def export_rlbench(
    root: Path, out: Path, *, tasks: Sequence[str] = (), layout: Layout = "upstream", on_episode: OnEpisode | None = None
) -> Path:
    """Write the episodes of a dataset as RLBench-style folders.

    Args:
        root: Folder of the dataset.
        out: The new folder.
        tasks: Only these tasks; all if empty.
        layout: `upstream` or `peract`.
        on_episode: Called after each episode.

    Raises:
        DatasetError: Something is missing or damaged, or an image cannot be encoded.
    """
    as_choice(layout, "layout", get_args(Layout))
    as_function(on_episode, "on_episode")
    out = as_path(out, "out")
    numbers: dict[str, int] = {}
    with new_folder(out) as folder:
        for stored, episode in opened(stored_episodes(root, tasks), on_episode):
            number = numbers.get(stored.task, 0)
            numbers[stored.task] = number + 1
            _write(folder, stored, episode.demo(), number, layout)
    return out


def _write(root: Path, stored: StoredEpisode, demo: Demo, number: int, layout: Layout) -> None:
    if layout == "peract":
        folder = root / stored.task / "all_variations" / "episodes" / f"episode{number}"
        folder.mkdir(parents=True)
        descriptions = folder
        (folder / VARIATION_FILE).write_bytes(dump(demo.variation_number))
    else:
        descriptions = root / stored.task / f"variation{demo.variation_number}"
        folder = descriptions / "episodes" / f"episode{stored.entry.episode}"
        folder.mkdir(parents=True)
    (descriptions / DESCRIPTIONS_FILE).write_bytes(dump(list(demo.instructions)))
    write_frames(folder, demo)


def write_frames(folder: Path, demo: Demo) -> None:
    """Write the images and the pickled observations of one demonstration to a folder, without instructions and variation.

    Args:
        folder: The folder; created if it does not exist.
        demo: The demonstration, which does not change.

    Raises:
        DatasetError: An image cannot be encoded, or is missing from some frames only.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for camera in CAMERAS:
        for product in PRODUCTS:
            _write_images(folder / f"{camera}_{product}", demo, camera, product)
    (folder / LOW_DIM_FILE).write_bytes(dump(_pickled(demo)))


def _write_images(folder: Path, demo: Demo, camera: str, product: str) -> None:
    images = [getattr(obs, f"{camera}_{product}") for obs in demo]
    if all(image is None for image in images):
        return
    folder.mkdir(exist_ok=True)
    for index, (obs, image) in enumerate(zip(demo, images)):
        if image is None:
            raise DatasetError(f"Frame {index} has no {camera}_{product}, but other frames do. Record the demonstration again.")
        if product == "depth":
            image = encode_depth(_normalised(image, obs, camera))
        elif product == "mask":
            image = encode_mask(image) if image.ndim == 2 else spread_bytes(image)
        write_png(folder / f"{index}.png", image)


def _normalised(depth: np.ndarray, obs: Observation, camera: str) -> np.ndarray:
    """Return depth in 0..1 between the clipping planes."""
    if not is_in_metres(depth, obs.misc, camera):
        return depth
    near, far = (obs.misc.get(f"{camera}_camera_{plane}") for plane in ("near", "far"))
    if near is None or far is None:
        raise DatasetError(f"Depth of '{camera}' is in metres, but `misc` lacks its clipping planes. Record it again.")
    return np.clip((depth - near) / (far - near), 0.0, 1.0)


def _pickled(demo: Demo) -> PickledDemo:
    """Return an object with the attributes that loaders of this format read."""
    result = PickledDemo()
    attributes: dict[str, Any] = {
        "_observations": [_pickled_observation(obs) for obs in demo],
        "random_seed": demo.random_seed,
        "num_reset_attempts": demo.num_reset_attempts,
        "variation_number": demo.variation_number,
        "attempt": demo.attempt,
    }
    result.__dict__.update(attributes)
    return result


def _pickled_observation(obs: Observation) -> PickledObservation:
    result = PickledObservation()
    values = {name: None if name in _IMAGES else getattr(obs, name) for name in FIELDS}
    if obs.ignore_collisions is not None:
        values["ignore_collisions"] = obs.ignore_collisions
    result.__dict__.update({**values, "misc": {k: v for k, v in obs.misc.items() if not k.endswith(IN_METRES)}})
    return result


_DECODE: dict[str, Callable[[np.ndarray], np.ndarray]] = {"rgb": np.array, "depth": decode_depth, "mask": decode_mask}
_DECODERS = {f"{camera}_{product}": decode for camera in CAMERAS for product, decode in _DECODE.items()}


def folder_episodes(root: Path, task: str, variation: int = ALL_VARIATIONS) -> list[Path]:
    """Return the episode folders of one variation, or of all (-1), in natural order; empty if there are none."""
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
        image_paths: Put the path of the PNG file into each image field and do not read the images.
        random_selection: Draw at random without replacement; otherwise take them in natural order.
        from_episode_number: First episode in natural order, counted from 0 over all variations. Not for a random selection.
        rng: Draws the random selection; required for one.
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
        raise EpisodeFileError(path, f"'{path / LOW_DIM_FILE}' contains no list of observations. Restore it.")
    frames = [_observation(o, path) for o in observations]
    _check_counts(path, len(frames))
    for name in FIELDS:
        if fields is not None and name not in fields:
            for frame in frames:
                setattr(frame, name, None)
        elif name in _DECODERS and (path / name).is_dir():
            _add_images(path / name, frames, image_paths)
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
        task_name=path.absolute().parents[2].name,
    )


def _arrays(state: object) -> dict[str, np.ndarray] | None:
    """Return the pickled snapshot of a world; None if there is none."""
    whole = isinstance(state, dict) and all(isinstance(value, np.ndarray) for value in state.values())
    return state if whole else None  # type: ignore[return-value]


def folder_descriptions(path: Path) -> tuple[str, ...]:
    """Return the instructions of an episode; empty if the file has other content, as some old files do."""
    path = as_path(path, "path")
    for folder in (path, path.parent.parent):
        if (folder / DESCRIPTIONS_FILE).is_file():
            found = load(folder / DESCRIPTIONS_FILE)
            return tuple(found) if isinstance(found, list) and all(isinstance(s, str) for s in found) else ()
    return ()


def _variation_of(path: Path) -> int | None:
    """Return the variation of a folder, given by its name or by the file inside."""
    match = _VARIATION.fullmatch(path.absolute().parents[1].name)
    if match:
        return int(match[1])
    if not (path / VARIATION_FILE).is_file():
        return None
    found = load(path / VARIATION_FILE)
    return found if isinstance(found, int) else None


def _variation_in(frame: Observation, path: Path) -> int:
    """Return the variation in the first frame, 0 by default."""
    found = frame.misc.get("variation_index", 0)
    if not isinstance(found, int | np.integer):
        raise EpisodeFileError(path, f"'{path / LOW_DIM_FILE}' has the variation {shown(found)}, not a whole number.")
    return int(found)


def _observation(pickled: Any, path: Path) -> Observation:
    known = getattr(pickled, "__dict__", None)
    if not isinstance(known, dict):
        raise EpisodeFileError(path, f"'{path / LOW_DIM_FILE}' has a {type(pickled).__name__} in place of an observation.")
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
                raise EpisodeFileError(path, f"Broken dataset: '{folder}' has {count} images for {frames} frames. Restore it.")


def _add_images(folder: Path, frames: list[Observation], image_paths: bool) -> None:
    for index, frame in enumerate(frames):
        file = folder / f"{index}.png"
        setattr(frame, folder.name, str(file) if image_paths else _DECODERS[folder.name](read_png(file)))


def _episodes(parent: Path) -> list[Path]:
    folders = [p for p in (parent / "episodes").glob("episode*") if _EPISODE.fullmatch(p.name) and (p / LOW_DIM_FILE).is_file()]
    return sorted(folders, key=_number)


def _number(path: Path) -> int:
    match = _EPISODE.fullmatch(path.name)
    return int(match[1]) if match else 0
