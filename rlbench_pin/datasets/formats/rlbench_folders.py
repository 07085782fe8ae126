"""Export to RLBench-style folders: PNG files for pictures, a pickled list of observations for the rest.

Two layouts: `upstream`, `<root>/<task>/variation<k>/episodes/episode<j>`, and `peract`, `<root>/<task>/all_variations/episodes/
episode<j>` with number and sentences of the variation inside each episode.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from rlbench_pin.datasets.formats.common import OnEpisode, StoredEpisode, new_folder, stored_episodes
from rlbench_pin.datasets.formats.rlbench_pickle import PickledDemo, PickledObservation, dump
from rlbench_pin.datasets.formats.rlbench_pictures import encode_depth, encode_mask, spread_bytes, write_png
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import CAMERAS, FIELDS, Demo, Observation
from rlbench_pin.values import as_choice, as_function, as_path

Layout = Literal["upstream", "peract"]
LOW_DIM_FILE, DESCRIPTIONS_FILE, VARIATION_FILE = "low_dim_obs.pkl", "variation_descriptions.pkl", "variation_number.pkl"
PRODUCTS = ("rgb", "depth", "mask")
_PICTURES = tuple(f"{camera}_{product}" for camera in CAMERAS for product in (*PRODUCTS, "point_cloud"))


def export_rlbench(
    root: Path, out: Path, *, tasks: Sequence[str] = (), layout: Layout = "upstream", on_episode: OnEpisode | None = None
) -> Path:
    """Write the episodes of a dataset as RLBench-style folders.

    Args:
        root: Folder of the dataset.
        out: The new folder.
        tasks: Only these; all when none is named.
        layout: `upstream` or `peract`.
        on_episode: Called after each episode.

    Raises:
        DatasetError: Something is missing or damaged, or a picture cannot be encoded.
    """
    as_choice(layout, "layout", get_args(Layout))
    as_function(on_episode, "on_episode")
    out = as_path(out, "out")
    numbers: dict[str, int] = {}
    with new_folder(out) as folder:
        for index, stored in enumerate(stored_episodes(root, tasks)):
            with stored.open() as episode:
                demo = episode.demo()
            number = numbers.get(stored.task, 0)
            numbers[stored.task] = number + 1
            _write(folder, stored, demo, number, layout)
            if on_episode is not None:
                on_episode(index + 1)
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
    """Write the pictures and the pickled observations of one demonstration into a folder; sentences and variation are not there.

    Args:
        folder: Where to; made when missing.
        demo: The demonstration. It is left as it is.

    Raises:
        DatasetError: A picture cannot be encoded, or is missing from some frames only.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for camera in CAMERAS:
        for product in PRODUCTS:
            _write_pictures(folder / f"{camera}_{product}", demo, camera, product)
    (folder / LOW_DIM_FILE).write_bytes(dump(_pickled(demo)))


def _write_pictures(folder: Path, demo: Demo, camera: str, product: str) -> None:
    pictures = [getattr(obs, f"{camera}_{product}") for obs in demo]
    if all(picture is None for picture in pictures):
        return
    folder.mkdir(exist_ok=True)
    for index, (obs, picture) in enumerate(zip(demo, pictures)):
        if picture is None:
            raise DatasetError(f"Frame {index} has no {camera}_{product}, others have. Record the demonstration again.")
        if product == "depth":
            picture = encode_depth(_normalised(picture, obs, camera))
        elif product == "mask":
            picture = encode_mask(picture) if picture.ndim == 2 else spread_bytes(picture)
        write_png(folder / f"{index}.png", picture)


def _normalised(depth: np.ndarray, obs: Observation, camera: str) -> np.ndarray:
    """Return depth in 0..1 between the clipping planes; metres are recognised by values above 1."""
    if np.max(depth) <= 1.0:
        return depth
    near, far = (obs.misc.get(f"{camera}_camera_{plane}") for plane in ("near", "far"))
    if near is None or far is None:
        raise DatasetError(f"Depth of '{camera}' is in metres, but `misc` lacks its clipping planes. Record it again.")
    return np.clip((depth - near) / (far - near), 0.0, 1.0)


def _pickled(demo: Demo) -> PickledDemo:
    """Return a stand-in with the attributes that loaders of this format read."""
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
    values = {name: None if name in _PICTURES else getattr(obs, name) for name in FIELDS}
    if obs.ignore_collisions is not None:
        values["ignore_collisions"] = obs.ignore_collisions
    result.__dict__.update({**values, "misc": dict(obs.misc)})
    return result
