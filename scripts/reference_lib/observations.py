"""The page about observations, from the fields, their settings, and one observation with all products enabled."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import MISSING, fields
from functools import cache
from itertools import groupby
from typing import Any

import numpy as np

from reference_lib.docs import attribute_docs, doc_of, shown, table
from rlbench_pin.environment import (
    CameraConfig,
    Environment,
    JointPositionActionMode,
    ModelObservationConfig,
    ObservationConfig,
)
from rlbench_pin.environment.observations.config import LOW_DIM_FIELDS
from rlbench_pin.observation import PRODUCTS, Observation, OptionalFields
from rlbench_pin.tasks import Task, library_names, task_class, task_scene
from rlbench_pin.tasks.task import low_dim_layout

SIZE = (32, 24)
"""Width and height of the images [px]; the page says w and h."""
_UNITS = {"pose": "", "hinge": " [rad]", "slider": " [m]"}
_TYPE = re.compile(r",? (uint8|int32|float32) \(h, w(, 3)?\)")

MISC: Mapping[str, str] = {
    "variation_index": "Variation of the episode.",
    "descriptions": "Instructions of the episode.",
    "joint_poses": "Pose of each arm joint in the world, base first; `ObservationConfig(joint_poses=False)` leaves them out.",
    "mask_names": "Id in masks -> name of the element; where a mask is requested.",
    "<camera>_camera_extrinsics": "Camera to world.",
    "<camera>_camera_intrinsics": "Pixels from camera coordinates; focal lengths are negative.",
    "<camera>_camera_near": "Near plane [m].",
    "<camera>_camera_far": "Far plane [m].",
    "<camera>_camera_depth_in_meters": "True; with `depth_in_meters`.",
    "wrist_camera_matrix": "Wrist camera to world; with `wrist_camera_matrix`.",
    "tip_jacobian": "`[linear, angular]` velocity of the tip along world axes per joint velocity.",
    "tip_jacobian_dot": "Its time derivative.",
    "mass_matrix": "Joint-space inertia [kg m^2].",
    "gravity": "Torques that carry the arm's weight [N m].",
    "coriolis": "C(q, v) v [N m].",
    "manipulability": "sqrt(det(J J^T)).",
    "world_distances": "The nearest pairs of arm and world, as `Distance` records: names, distance [m], points, normal.",
    "self_distances": "The nearest pairs of the arm with itself.",
    "joint_position_action": "In demonstrations, from the second frame on: the command that led here, joints [rad] and gripper.",
}
"""Key of `Observation.misc` -> what it is."""


def everything() -> ObservationConfig:
    """Return settings with everything switched on and small images."""
    config = ObservationConfig()
    config.set_all(True)
    for camera in config.cameras().values():
        camera.image_size = SIZE
    config.front_camera.depth_in_meters = True
    config.model = ModelObservationConfig(
        **{
            f.name: 1 if isinstance(f.default, int) and not isinstance(f.default, bool) else True
            for f in fields(ModelObservationConfig)
        }
    )
    return config


@cache
def observed() -> Observation:
    """Return the first observation of `reach_target`, with everything in it."""
    with Environment(JointPositionActionMode(), obs_config=everything()) as environment:
        return environment.get_task("reach_target").reset(seed=0)[1]


def parts() -> dict[str, str]:
    """Return what the page has generated, by marker."""
    return {
        "low-dim": _low_dim(),
        "pictures": _pictures(),
        "misc": _misc(),
        "settings": _settings(ObservationConfig),
        "cameras": _settings(CameraConfig),
        "tasks": _tasks(),
    }


def shape_of(value: Any) -> str:
    """Return shape and type of a value of an observation, with w and h for the size of images."""
    if isinstance(value, list | tuple):
        return f"{type(value).__name__} of {shape_of(value[0])}"
    if not isinstance(value, np.ndarray):
        return type(value).__name__
    names = {SIZE[1]: "h", SIZE[0]: "w"} if value.shape[:2] == SIZE[::-1] else {}
    inner = ", ".join(str(names.get(n, n)) for n in value.shape)
    return f"({inner}{',' if value.ndim == 1 else ''}) {value.dtype}"


def _low_dim() -> str:
    docs, observation, config = attribute_docs(Observation), observed(), ObservationConfig()
    rows = [
        (
            f"`{name}`",
            "(k,) float64" if name == "task_low_dim_state" else shape_of(getattr(observation, name)),
            docs[name],
            "on" if getattr(config, name) else "off",
        )
        for name in LOW_DIM_FIELDS
    ]
    rows.append(("`ignore_collisions`", "bool", attribute_docs(OptionalFields)["ignore_collisions"], "on"))
    return table(("Field", "Shape, type", "What it is", "By default"), rows)


def _pictures() -> str:
    docs, observation = attribute_docs(CameraConfig), observed()
    rows = [(f"`<camera>_{p}`", shape_of(getattr(observation, f"front_{p}")), _TYPE.sub("", docs[p])) for p in PRODUCTS]
    return table(("Field", "Shape, type", "What it is"), rows)


def _misc() -> str:
    misc = {**observed().misc, "joint_position_action": np.zeros(8)}
    rows = [(f"`{name}`", shape_of(misc[name.replace("<camera>", "front")]), text) for name, text in MISC.items()]
    return table(("Key", "Shape, type", "What it is"), rows)


def _settings(cls: type) -> str:
    """Return the settings that say something of their own; fields of observations are switched by their names."""
    docs = attribute_docs(cls)
    rows = []
    for f in fields(cls):
        if f.name in docs:
            made = "" if f.default_factory is MISSING else f"{f.default_factory.__name__}()"  # type: ignore[attr-defined]
            rows.append((f"`{f.name}`", f"`{made or shown(f.default)}`", docs[f.name]))
    return table(("Setting", "Default", "Meaning"), rows)


def _tasks() -> str:
    rows = [(f"`{name}`", *layout_of(task_class(name))) for name in sorted(library_names())]
    return table(("Task", "Numbers", "In order"), rows, "lrl")


def layout_of(task: type[Task]) -> tuple[str, str]:
    """Return how many numbers the state of a task has, and what they are."""
    if task.get_low_dim_state is not Task.get_low_dim_state:
        text = doc_of(task.get_low_dim_state).first
        return str(int(text.partition("shape (")[2].partition(",")[0])), text.removeprefix("Return the ").split(", shape")[
            0
        ] + " [m]"
    layout = low_dim_layout(task_scene(task))
    groups = [(kind, [f"`{part.name}`" for part in group]) for kind, group in groupby(layout, key=lambda part: part.kind)]
    return str(sum(part.size for part in layout)), "; ".join(f"{', '.join(names)}{_UNITS[kind]}" for kind, names in groups)
