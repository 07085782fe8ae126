"""Objects rest where the catalogue says, and moving parts run free."""

from __future__ import annotations

import numpy as np
import pybullet as p
import pytest

from rlbench_pin.assets import ASSETS
from rlbench_pin.spatial import TABLE_HEIGHT
from tests.assets.support import base_position, client, joint_table, load, object_urdf

TOP = TABLE_HEIGHT
REST = {
    "cube": 0.025,
    "cube_small": 0.02,
    "cube_45": 0.0225,
    "block_60": 0.03,
    "chicken": 0.02,
    "steak": 0.01,
    "rubbish": 0.022,
    "tomato": 0.0275,
}
"""Height of the origin above the surface that an object stands on [m]."""


def _simulate(seconds: float, number: int) -> None:
    for _ in range(round(seconds * 240)):
        p.stepSimulation(physicsClientId=number)


@pytest.mark.parametrize("name", sorted(REST))
def test_objects_rest_at_their_height(name: str) -> None:
    """A free object put on the table at its resting height stays there."""
    with client() as number:
        load(ASSETS / "room/table.urdf", number)
        start = (0.2, 0.1, TOP + REST[name] + 0.0005)
        body = load(object_urdf(name), number, start, fixed=False)
        _simulate(2.0, number)
        assert np.allclose(base_position(body, number), (0.2, 0.1, TOP + REST[name]), atol=1.5e-3)


def test_the_lid_stays_on_the_saucepan() -> None:
    """The closed lid lies still, also when it was put down 2 mm beside the middle."""
    with client() as number:
        load(object_urdf("saucepan"), number)
        lid = load(object_urdf("saucepan_lid"), number, (0.002, 0.0, 0.1205 + 0.001), fixed=False)
        _simulate(2.0, number)
        assert np.allclose(base_position(lid, number), (0.002, 0.0, 0.1205), atol=1.5e-3)


@pytest.mark.parametrize(("name", "height"), [("chicken", 0.16), ("steak", 0.15)])
def test_meat_lies_on_the_grate(name: str, height: float) -> None:
    """Meat rests on the grate at its own resting height above it."""
    with client() as number:
        load(object_urdf("grill"), number)
        body = load(object_urdf(name), number, (0.05, 0.03, height + 0.001), fixed=False)
        _simulate(2.0, number)
        assert np.allclose(base_position(body, number), (0.05, 0.03, height), atol=1.5e-3)


def test_rubbish_falls_to_the_bottom_of_the_bin() -> None:
    """The bin is hollow: what is dropped over it lands on its floor."""
    with client() as number:
        load(object_urdf("bin"), number)
        body = load(object_urdf("rubbish"), number, (0.01, -0.01, 0.3), fixed=False)
        _simulate(2.0, number)
        x, y, z = base_position(body, number)
        assert 0.02 < z < 0.035
        assert np.hypot(x, y) < 0.045


@pytest.mark.parametrize("name", ["chest", "microwave", "button"])
def test_moving_parts_never_touch_the_rest(name: str) -> None:
    """Over the whole range of every joint there is a gap to all other links, and no contact with the fixed part."""
    with client() as number:
        body = load(object_urdf(name), number)
        for joint, (index, _, _) in joint_table(body, number).items():
            lower, upper = p.getJointInfo(body, index, physicsClientId=number)[8:10]
            others = [i for i in range(-1, p.getNumJoints(body, physicsClientId=number)) if i != index]
            for value in np.linspace(lower, upper, 25):
                p.resetJointState(body, index, value, physicsClientId=number)
                gaps = [c[8] for i in others for c in p.getClosestPoints(body, body, 0.01, index, i, physicsClientId=number)]
                assert min(gaps, default=1.0) > 1e-4, (joint, value)
            p.resetJointState(body, index, 0.0, physicsClientId=number)


def test_a_flat_weight_on_a_button_rests_on_its_guard() -> None:
    """What is wider than the guard presses the cap by less than the 3 mm that count; the guard stops it."""
    with client() as number:
        body = load(object_urdf("button"), number)
        cap = joint_table(body, number)["cap_joint"][0]
        p.setJointMotorControl2(body, cap, p.VELOCITY_CONTROL, force=0.0, physicsClientId=number)
        shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=(0.05, 0.05, 0.01), physicsClientId=number)
        plate = p.createMultiBody(2.0, shape, basePosition=(0.0, 0.0, 0.055), physicsClientId=number)
        for _ in range(240):
            spring = -400.0 * p.getJointState(body, cap, physicsClientId=number)[0]
            p.setJointMotorControl2(body, cap, p.TORQUE_CONTROL, force=spring, physicsClientId=number)
            p.stepSimulation(physicsClientId=number)
        assert 0.001 < p.getJointState(body, cap, physicsClientId=number)[0] < 0.003
        assert p.getContactPoints(plate, body, -1, -1, physicsClientId=number)


def test_drawers_carry_things() -> None:
    """A cube dropped into an open drawer stays in it, above its bottom."""
    with client() as number:
        chest = load(object_urdf("chest"), number)
        index = joint_table(chest, number)["drawer_middle"][0]
        p.resetJointState(chest, index, 0.18, physicsClientId=number)
        cube = load(object_urdf("cube_small"), number, (-0.22, 0.0, 0.25), fixed=False)
        _simulate(1.5, number)
        assert np.allclose(base_position(cube, number), (-0.22, 0.0, 0.2025 - 0.034 + 0.02), atol=2e-3)
