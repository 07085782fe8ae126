"""The Panda's gripper fits where it has to: handles, knobs, meats and blocks."""

from __future__ import annotations

from collections.abc import Iterator

import coal
import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.robot.geometry import link_geometry
from rlbench_pin.spatial import FloatArray
from tests.assets.support import PANDA, object_urdf

HAND = ("panda_hand", "panda_leftfinger", "panda_rightfinger")
DOWN = np.diag([1.0, -1.0, -1.0])
"""Tip z down, fingers along y."""
FORWARD_VERTICAL = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Tip z along +x, fingers along z."""
FORWARD_LEVEL = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""Tip z along +x, fingers along y."""
TABLE = (coal.Box(2.0, 2.0, 0.1), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.05])))

CASES = [
    *(("chest", FORWARD_VERTICAL, (-0.175, 0.0, z), 0.012) for z in (0.1205, 0.2175, 0.3145)),
    ("microwave", FORWARD_LEVEL, (-0.182, -0.065, 0.125), 0.012),
    ("saucepan_lid", DOWN, (0.0, 0.0, 0.0), 0.03),
    ("cube", DOWN, (0.0, 0.0, 0.0), 0.05),
    ("cube_small", DOWN, (0.0, 0.0, 0.0), 0.04),
    ("cube_45", DOWN, (0.0, 0.0, 0.0), 0.045),
    ("rubbish", DOWN, (0.0, 0.0, 0.0), 0.05),
    ("chicken", DOWN, (-0.01, 0.0, 0.0), 0.045),
    ("steak", DOWN, (0.0, 0.0, 0.002), 0.06),
]
"""Object, turn of the tip, its place in the object's frame, width of what is grasped [m]."""


def _hand(turn: FloatArray, place: tuple[float, float, float], opening: float) -> Iterator[tuple[str, object, pin.SE3]]:
    """Give link, shape and placement of the hand's shapes, the tip being at a place and each finger at `opening`."""
    model = pin.buildModelFromUrdf(str(PANDA))
    data = model.createData()
    q = pin.neutral(model)
    q[-2:] = opening
    pin.framesForwardKinematics(model, data, q)
    tip = data.oMf[model.getFrameId("panda_hand_tcp")]
    for link in HAND:
        frame = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
        for shape, local in link_geometry(PANDA)[link]:
            yield link, shape, pin.SE3(turn, np.array(place)) * tip.actInv(frame) * local


def _object(name: str) -> Iterator[tuple[object, pin.SE3]]:
    """Give the shapes of an object with all joints at 0, and the table below a standing one."""
    path = object_urdf(name)
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    for link, parts in link_geometry(path).items():
        for shape, local in parts:
            yield shape, data.oMf[model.getFrameId(link, pin.FrameType.BODY)] * local
    if name in ("chest", "microwave"):
        yield TABLE


def _gap(shape: object, place: pin.SE3, other: object, other_place: pin.SE3) -> float:
    """Return the distance between two shapes [m], negative when they overlap."""
    return coal.distance(
        shape,
        coal.Transform3s(place.rotation, place.translation),
        other,
        coal.Transform3s(other_place.rotation, other_place.translation),
        coal.DistanceRequest(),
        coal.DistanceResult(),
    )


@pytest.mark.parametrize(("name", "turn", "place", "width"), CASES)
def test_the_open_hand_reaches_the_grasp(name: str, turn: FloatArray, place: tuple[float, float, float], width: float) -> None:
    """On the last 10 cm of a straight approach and at the grasp the open gripper touches neither the object nor the table."""
    for back in (0.1, 0.06, 0.03, 0.015, 0.0):
        away = tuple(np.array(place) - back * turn[:, 2])
        gaps = [_gap(s, m, o, om) for _, s, m in _hand(turn, away, 0.04) for o, om in _object(name)]
        assert min(gaps) > 1e-3, (back, min(gaps))


@pytest.mark.parametrize(("name", "turn", "place", "width"), CASES)
def test_both_fingers_meet_the_object(name: str, turn: FloatArray, place: tuple[float, float, float], width: float) -> None:
    """Closed a little below the width of the thing, both fingers press on it and the gripper itself stays free."""
    parts = tuple(_object(name))
    gaps = {link: [] for link in HAND}
    for link, shape, at in _hand(turn, place, width / 2.0 - 0.004):
        gaps[link] += [_gap(shape, at, other, other_at) for other, other_at in parts]
    assert min(gaps["panda_leftfinger"]) < 0.0
    assert min(gaps["panda_rightfinger"]) < 0.0
    assert min(gaps["panda_hand"]) > 1e-3
