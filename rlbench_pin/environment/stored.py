"""Stored demonstrations, read with the fields and image sizes of an observation config."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.datasets import Episode, checked_task_name, stored_demos
from rlbench_pin.datasets.formats.rlbench import folder_demos, folder_descriptions, folder_episodes, is_in_metres
from rlbench_pin.datasets.manifest import has_manifest
from rlbench_pin.datasets.reader import check_there, counted_files
from rlbench_pin.environment.observations.config import CameraConfig, ObservationConfig
from rlbench_pin.environment.observations.observe import spread_mask
from rlbench_pin.errors import DatasetError, InvalidArgument
from rlbench_pin.observation import CAMERAS, IN_METRES, LOW_DIM, PRODUCTS, Demo, Observation
from rlbench_pin.values import as_flag, as_whole


@dataclass(frozen=True)
class StoredSelection:
    """A selection of the stored demonstrations of a task."""

    amount: int
    """Number of demonstrations; -1 selects all."""
    variation: int
    """Variation of the task; -1 selects any."""
    image_paths: bool
    """Do not read images: fields contain paths of PNG files, or strings for `datasets.read_image`."""
    random_selection: bool
    """Select at random."""
    from_episode_number: int
    """Index of the first episode without `random_selection`; episodes are in natural order."""

    def __post_init__(self) -> None:
        """Raise InvalidArgument for an invalid number or switch; reading checks the ranges."""
        for name in ("amount", "variation", "from_episode_number"):
            as_whole(getattr(self, name), name, InvalidArgument)
        for name in ("image_paths", "random_selection"):
            as_flag(getattr(self, name), name, InvalidArgument)


def read_stored_demos(
    dataset_root: str, task_name: str, wanted: StoredSelection, config: ObservationConfig, rng: np.random.Generator
) -> list[Demo]:
    """Read stored demonstrations of one task.

    The root contains our episode files or RLBench-style folders.

    Args:
        dataset_root: Folder of the dataset.
        task_name: Name of the task.
        wanted: The selected demonstrations.
        config: Selected fields, and format of images.
        rng: Generator that draws the episodes.

    Raises:
        DatasetError: No dataset root was given, a file is missing or damaged, or fewer demonstrations are stored.
    """
    root = _checked_root(dataset_root, "demonstrations", ", or ask for `live_demos=True`")
    read = folder_demos if _holds_folders(root, task_name) else stored_demos
    demos = read(
        root, task_name, wanted.amount, wanted.variation,
        image_paths=wanted.image_paths, random_selection=wanted.random_selection,
        from_episode_number=wanted.from_episode_number, rng=rng, fields=wanted_fields(config),
    )  # fmt: skip
    for observation in () if wanted.image_paths else chain.from_iterable(demos):
        fit(observation, config)
    return demos


def read_stored_descriptions(dataset_root: str, task_name: str, episode: int) -> list[str]:
    """Return the instructions of one stored episode; its index counts through all variations in natural order.

    Raises:
        DatasetError: There is no dataset root, or no such episode.
    """
    root, episode = _checked_root(dataset_root, "instructions"), as_whole(episode, "episode", InvalidArgument)
    folders = _holds_folders(root, task_name)
    paths = folder_episodes(root, task_name) if folders else list(counted_files(root, task_name))
    if not 0 <= episode < len(paths):
        raise DatasetError(
            f"'{root}' contains {len(paths)} episodes of '{task_name}', so there is no episode {episode}. "
            f"Choose an episode below {len(paths)}, or record more."
        )
    if folders:
        return list(folder_descriptions(paths[episode]))
    check_there(paths[episode])
    with Episode(paths[episode]) as stored:
        return list(stored.instructions)


def _checked_root(dataset_root: str, what: str, otherwise: str = "") -> Path:
    if not dataset_root:
        raise DatasetError(
            f"No dataset root was given, so there are no stored {what}. Pass `Environment(dataset_root=...)`{otherwise}."
        )
    return Path(dataset_root)


def _holds_folders(root: Path, task: str) -> bool:
    """Return whether a task is stored in RLBench-style folders."""
    return not has_manifest(root, checked_task_name(task)) and bool(folder_episodes(root, task))


def wanted_fields(config: ObservationConfig) -> list[str]:
    """Return the fields to read from the disk, including depth if a point cloud may be computed from it."""
    fields = [name for name in (*LOW_DIM, "gripper_matrix") if getattr(config, name)]
    for name, camera in config.cameras().items():
        products = {product for product in PRODUCTS if getattr(camera, product)}
        if camera.point_cloud:
            products.add("depth")
        fields += [f"{name}_{product}" for product in sorted(products)]
    return fields + [f"{name}_{product}" for name in config.extra_cameras for product in PRODUCTS]


def fit(observation: Observation, config: ObservationConfig) -> None:
    """Convert the images of one stored observation to the format of a config, in place.

    Images are scaled with the nearest pixel, so that depth and ids stay valid. The intrinsics in `misc` are scaled too.
    """
    for name in CAMERAS:
        _fit_camera(observation, name, config.camera(name))


def _fit_camera(observation: Observation, name: str, config: CameraConfig) -> None:
    rgb, depth, mask, cloud = (getattr(observation, f"{name}_{product}") for product in PRODUCTS)
    stored = next((p for p in (rgb, depth, mask, cloud) if p is not None), None)
    if stored is None:
        return
    if stored.shape[:2] != config.image_size[::-1]:
        rgb, depth, mask, cloud = (None if p is None else resize(p, config.image_size) for p in (rgb, depth, mask, cloud))
        _scale_intrinsics(observation.misc, name, stored.shape[1::-1], config.image_size)
    if config.point_cloud and cloud is None and depth is not None:
        cloud = cloud_from_depth(_in_metres(depth, observation.misc, name), observation.misc, name)
    if config.depth and config.depth_in_meters and depth is not None:
        depth = _in_metres(depth, observation.misc, name)
        observation.misc[f"{name}_{IN_METRES}"] = True
    if mask is not None and not config.masks_as_one_channel and mask.ndim == 2:
        mask = spread_mask(mask)
    for product, image in zip(PRODUCTS, (rgb, depth if config.depth else None, mask, cloud), strict=True):
        setattr(observation, f"{name}_{product}", image)


def resize(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return an image of another width and height [px], each pixel the nearest of the original."""
    (h, w), (width, height) = image.shape[:2], size
    rows = ((np.arange(height) + 0.5) * h / height).astype(int)
    columns = ((np.arange(width) + 0.5) * w / width).astype(int)
    return np.ascontiguousarray(image[rows][:, columns])


def cloud_from_depth(metres: np.ndarray, misc: dict[str, Any], name: str) -> np.ndarray:
    """Return the world coordinates [m] of every pixel, float32 (h, w, 3).

    world = extrinsics * (inverse(intrinsics) * (u, v, 1) * depth)
    """
    extrinsics, intrinsics = _matrix(misc, name, "extrinsics"), _matrix(misc, name, "intrinsics")
    v, u = np.indices(metres.shape)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(intrinsics).T
    points = rays * metres[..., None].astype(float) @ extrinsics[:3, :3].T + extrinsics[:3, 3]
    return points.astype(np.float32)


def _in_metres(depth: np.ndarray, misc: dict[str, Any], name: str) -> np.ndarray:
    """Return depth in [m]."""
    if is_in_metres(depth, misc, name):
        return depth
    near, far = float(_matrix(misc, name, "near")), float(_matrix(misc, name, "far"))
    return (near + depth.astype(float) * (far - near)).astype(np.float32)


def _scale_intrinsics(misc: dict[str, Any], name: str, before: tuple[int, int], after: tuple[int, int]) -> None:
    key = f"{name}_camera_intrinsics"
    if key in misc:
        misc[key] = np.diag([after[0] / before[0], after[1] / before[1], 1.0]) @ np.asarray(misc[key], dtype=float)


def _matrix(misc: dict[str, Any], name: str, what: str) -> np.ndarray:
    key = f"{name}_camera_{what}"
    if key not in misc:
        raise DatasetError(
            f"The stored images of '{name}' lack '{key}', which depth in metres and point clouds need. "
            f"Disable `point_cloud` and `depth_in_meters` of that camera."
        )
    return np.asarray(misc[key], dtype=float)
