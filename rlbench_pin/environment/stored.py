"""Stored demonstrations, trimmed to what an observation config asks for."""

from __future__ import annotations

import numpy as np

from rlbench_pin.datasets import stored_demos
from rlbench_pin.environment.observation_config import ObservationConfig
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import CAMERAS, LOW_DIM, PRODUCTS, Demo


def read_stored_demos(
    dataset_root: str,
    task_name: str,
    amount: int,
    variation: int,
    config: ObservationConfig,
    *,
    image_paths: bool,
    random_selection: bool,
    from_episode_number: int,
    rng: np.random.Generator,
) -> list[Demo]:
    """Read `amount` stored demonstrations of one task and variation (-1: all of either).

    Raises:
        DatasetError: No dataset root was given, something is missing or broken, or more are wanted than stored.
    """
    if not dataset_root:
        raise DatasetError(
            "No dataset root was given, so there are no stored demonstrations. "
            "Pass `Environment(dataset_root=...)`, or ask for `live_demos=True`."
        )
    demos = stored_demos(
        dataset_root,
        task_name,
        amount,
        variation,
        image_paths=image_paths,
        random_selection=random_selection,
        from_episode_number=from_episode_number,
        rng=rng,
    )
    for demo in demos:
        _trim(demo, config)
    return demos


def _trim(demo: Demo, config: ObservationConfig) -> None:
    """Set to None what the config does not ask for."""
    unwanted = [name for name in (*LOW_DIM, "gripper_matrix") if not getattr(config, name, True)]
    unwanted += [f"{c}_{p}" for c in CAMERAS for p in PRODUCTS if not getattr(getattr(config, f"{c}_camera"), p)]
    for observation in demo:
        for name in unwanted:
            setattr(observation, name, None)
