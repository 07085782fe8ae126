"""Sensors see what reaches into their volume."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.robot import geometry
from rlbench_pin.scene.spec import BodySpec, SceneSpec, SensorSpec
from tests.sim.support import UPRIGHT, build

PLACE = np.array([0.3, 0.0, 1.0])


@pytest.fixture(scope="module")
def world():
    """A world with one sensor of each shape, a cube and a ball without collision geometry."""

    def sensor(name, shape, size):
        return SensorSpec(name=name, shape=shape, size=size, parent="world", pose=(*PLACE, *UPRIGHT))

    ball = BodySpec(name="ball", asset="objects/ball_marker/ball_marker.urdf", parent="world", fixed=True)
    scene = SceneSpec(
        format=1,
        body=(BodySpec(name="cube", asset="objects/cube/cube.urdf", parent="world", fixed=True), ball),
        sensor=(
            sensor("box", "box", (0.1, 0.2, 0.3)),
            sensor("cylinder", "cylinder", (0.2, 0.1)),
            sensor("sphere", "sphere", (0.2,)),
            SensorSpec(name="on_cube", shape="box", size=(0.01, 0.01, 0.01), parent="cube", pose=(0.0, 0.0, 0.05, *UPRIGHT)),
        ),
    )
    with build(scene) as world:
        yield world


@pytest.mark.parametrize("body", ["cube", "ball"])
@pytest.mark.parametrize(
    ("sensor", "direction", "reach"),
    [
        ("box", (1, 0, 0), 0.05),
        ("box", (0, 1, 0), 0.10),
        ("box", (0, 0, 1), 0.15),
        ("cylinder", (1, 0, 0), 0.10),
        ("cylinder", (0, 0, 1), 0.05),
        ("sphere", (0, 0, 1), 0.10),
    ],
)
def test_a_body_is_seen_when_it_reaches_in(world, body, sensor, direction, reach):
    """Cube (solid) and ball (only seen) are detected up to the volume's surface plus their own half size."""
    for distance, seen in ((reach + 0.024, True), (reach + 0.026, False)):
        world.body(body).set_pose([*(PLACE + distance * np.array(direction)), *UPRIGHT])
        assert world.sensor(sensor).detects(body) is seen


@pytest.mark.parametrize(
    ("sensor", "inside", "outside"),
    [("box", (0.049, 0.099, 0.149), (0.051, 0, 0)), ("sphere", (0.05, 0.05, 0.05), (0.06, 0.06, 0.06))],
)
def test_points(world, sensor, inside, outside):
    """A point is inside or outside."""
    assert world.sensor(sensor).contains(PLACE + inside)
    assert not world.sensor(sensor).contains(PLACE + outside)


def test_a_sensor_moves_with_its_parent(world):
    """A sensor on the cube sees the ball only where the cube takes it."""
    world.body("cube").set_pose([0.1, 0.1, 1.0, *UPRIGHT])
    world.body("ball").set_pose([0.1, 0.1, 1.05, *UPRIGHT])
    assert world.sensor("on_cube").detects("ball")
    world.body("cube").set_pose([0.2, 0.1, 1.0, *UPRIGHT])
    assert not world.sensor("on_cube").detects("ball")


def test_a_body_far_away_is_not_compared_and_one_nearby_is(world):
    """Wherever a turned cube lies, a sensor says what Coal says of the shapes themselves."""
    cube, sensor, rng = world.body("cube"), world.sensor("cylinder"), np.random.default_rng(0)
    ((box, _),) = geometry.solid_geometry(cube.model.urdf)["cube"]
    volume, answers = geometry.volume("cylinder", sensor.size), []
    for _ in range(300):
        quaternion = rng.normal(size=4)
        cube.set_pose([*(PLACE + rng.uniform(-0.16, 0.16, 3)), *(quaternion / np.linalg.norm(quaternion))])
        touches = geometry.overlaps(volume, sensor.placement(), [(box, pin.SE3.Identity())], cube.model.placement())
        answers.append(touches)
        assert sensor.detects("cube") == touches
    assert 50 < sum(answers) < 250
