"""Bodies and their joints."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, JointSpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import euler_to_quaternion, pose_to_se3
from tests.sim.support import build, furniture_scene, steps

ASSETS = ("cup/cup", "drop/drop", "convex/convex_03", "lever_door/lever_door", "stain/stain")
SCENE = SceneSpec(
    format=2,
    body=tuple(
        BodySpec(name=asset.split("/")[0], asset=f"objects/{asset}.urdf", pose=(0.3 * i, 0.1, 0.2, 0.5, 0.3, 0.2, 0.787401))
        for i, asset in enumerate(ASSETS)
    ),
)


def test_a_body_reaches_along_axes_as_far_as_its_box_along_them() -> None:
    """Boxes, cylinders, balls, hulls, several links."""
    frame = np.concatenate([np.zeros(3), euler_to_quaternion(0.3, -0.7, 1.9)])
    with World(SCENE, robot_description("panda")) as world:
        for body in world.bodies.values():
            reach = body.extent_along(pose_to_se3(frame).rotation.T)
            np.testing.assert_allclose(reach, body.bounds_from(frame), atol=1e-12, err_msg=body.name)


def test_the_box_of_a_body_of_one_link_is_the_same_wherever_it_is() -> None:
    """It is worked out once for each file, and everyone has a copy."""
    with World(SCENE, robot_description("panda")) as world:
        cup = world.body("cup")
        np.testing.assert_allclose(cup.bounds(), cup.bounds_from(cup.pose), atol=1e-12)
        cup.bounds()[:] = 0.0
        assert np.ptp(cup.bounds(), axis=0).min() > 0.05


@pytest.fixture
def world():
    """A world with furniture."""
    with build(furniture_scene()) as world:
        yield world


def test_joints_start_where_the_scene_says(world):
    """Start values hold over time, with friction, a lock, or neither; the weight of the cap presses its spring by 0.65 mm."""
    values = {
        "chest/drawer_top": 0.1,
        "chest/drawer_middle": 0.05,
        "chest/drawer_bottom": 0.0,
        "button/cap_joint": 0.02 * 9.81 / 300.0,
    }
    steps(world, 20)
    for name, value in values.items():
        assert world.joint(name).position == pytest.approx(value, abs=1e-4)
        assert abs(world.joint(name).velocity) < 1e-3


def test_a_spring_returns(world):
    """A pressed button comes back within a few ticks, but for the weight of its cap, and rests."""
    cap = world.joint("button/cap_joint")
    cap.set_position(0.006)
    steps(world, 6)
    assert cap.position == pytest.approx(0.02 * 9.81 / 300.0, abs=1e-4)
    assert abs(cap.velocity) < 1e-3


def test_a_lock_holds_until_it_is_opened(world):
    """A locked drawer keeps its value; unlocked it moves; `lock` holds it where it is."""
    drawer = world.joint("chest/drawer_middle")
    assert drawer.locked
    drawer.set_position(0.08)
    steps(world, 5)
    assert drawer.position == pytest.approx(0.08, abs=1e-4)
    drawer.unlock()
    drawer.set_state(0.08, 0.3)
    steps(world, 5)
    assert drawer.position > 0.09
    drawer.lock()
    here = drawer.position
    steps(world, 5)
    assert drawer.position == pytest.approx(here, abs=1e-3)


def test_limits_and_bad_values(world):
    """Limits are those of the URDF; NaN is refused."""
    drawer = world.joint("chest/drawer_top")
    assert (drawer.lower, drawer.upper) == (0.0, 0.22)
    with pytest.raises(ValueError, match="finite"):
        drawer.set_position(np.nan)


def test_friction_stops_a_joint(world):
    """A drawer that was given a speed stops by the dry friction of its scene entry and stays."""
    spec = JointSpec(name="chest/drawer_top", friction=3.0)
    drawer = world.joint("chest/drawer_top")
    drawer.configure(spec)
    drawer.set_state(0.05, 0.2)
    steps(world, 10)
    slid = drawer.position - 0.05
    assert 0.0 < slid < 0.01  # 0.6 kg at 0.2 m/s against 3 N
    assert abs(drawer.velocity) < 1e-4
