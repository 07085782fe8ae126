"""What the page about observations says is true of demonstrations and of every task."""

from __future__ import annotations

import re
from dataclasses import fields

import numpy as np
import pytest
from reference_lib import observations

from rlbench_pin.environment import Environment, JointPositionActionMode, ModelObservationConfig
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.observation import FIELDS, Observation
from rlbench_pin.tasks import Task, library_names, task_class
from tests.reference.support import part, rows


def test_every_field_of_observations_has_its_row() -> None:
    """Joints, gripper and task by name; images by what they deliver; misc by key, model-based ones by their setting."""
    found = {row[0] for marker in ("low-dim", "pictures") for row in rows(part("observations", marker))}
    pictures = {name.removeprefix("<camera>") for name in found if name.startswith("<camera>")}
    assert {name for name in FIELDS if name not in found and not name.endswith(tuple(pictures))} == {"ignore_collisions"} - found
    assert {f.name for f in fields(ModelObservationConfig)} <= {row[0] for row in rows(part("observations", "misc"))}


@pytest.mark.simulation
def test_a_demonstration_has_the_shapes_types_and_keys_of_the_page() -> None:
    """Of another task than that the page was written from."""
    config = observations.everything()
    with Environment(JointPositionActionMode(), obs_config=config) as environment:
        (demo,) = environment.get_task("push_button").get_demos(1, live_demos=True, seed=0)
    frame: Observation = demo[-1]
    for marker in ("low-dim", "pictures"):
        for name, shape, *_ in rows(part("observations", marker)):
            for camera in config.cameras() if "<camera>" in name else ("",):
                value = getattr(frame, name.replace("<camera>", camera))
                given = observations.shape_of(value)
                assert (re.sub(r"^\(\d+,\)", "(k,)", given) if name == "task_low_dim_state" else given) == shape, name
    listed = {row[0]: row[1] for row in rows(part("observations", "misc"))}
    for name, value in frame.misc.items():
        key = re.sub(rf"^({'|'.join(config.cameras())})(?=_camera_(?!matrix))", "<camera>", name)
        assert observations.shape_of(value) == listed.pop(key, observations.shape_of(value)), name
        assert key in observations.MISC
    assert listed == {}


@pytest.mark.simulation
@pytest.mark.parametrize("name", sorted(library_names()))
def test_the_state_of_a_task_has_the_numbers_of_the_page(name: str) -> None:
    """As many as listed, whatever the variation; by default the poses and joint values of what is listed, in that order."""
    _, count, text = next(row for row in rows(part("observations", "tasks")) if row[0] == name)
    with Environment(JointPositionActionMode(), obs_config=low_dim_config()) as environment:
        task = environment.get_task(name)
        for variation in {0, task.variation_count() - 1}:
            _, observation = task.reset(seed=1, variation=variation)
            assert observation.task_low_dim_state is not None
            assert len(observation.task_low_dim_state) == int(count)
        if task_class(name).get_low_dim_state is not Task.get_low_dim_state:
            return
        here, world = 0, task.world
        for thing in re.findall(r"[\w/]+(?=[`,;]|$)", re.sub(r" \[\w+\]", "", text)):
            values = np.atleast_1d(world.joint(thing).position if "/" in thing else world.body(thing).pose)
            np.testing.assert_array_equal(observation.task_low_dim_state[here : here + len(values)], values, err_msg=thing)
            here += len(values)
        assert here == int(count)
