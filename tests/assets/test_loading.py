"""Every asset means the same in PyBullet and in Pinocchio with Coal."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pybullet as p
import pytest

from rlbench_pin.robot.geometry import bounds, link_geometry
from tests.assets.support import ROBOTS, URDFS, client, geometry, inertial_place, joint_table, label, load, random_configuration

SHAPES = {coal.Box: p.GEOM_BOX, coal.Cylinder: p.GEOM_CYLINDER, coal.Sphere: p.GEOM_SPHERE}

LOOSE = {
    **{path.stem: np.inf for path in ROBOTS},
    **dict.fromkeys(
        ("alarm_clock", "chest", "chest_graded", "chest_tall", "chest_with_knobs", "chest_with_stops", "fridge_red"), 0.05
    ),
    **dict.fromkeys(("dishwasher", "fridge", "window"), 0.04),
}
"""How much larger PyBullet's boxes may be where shapes are turned in their link [m]."""


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_link_frames_agree(path: Path) -> None:
    """The frames of all links agree at random joint values."""
    model, _ = geometry(path)
    data = model.createData()
    rng = np.random.default_rng(1)
    with client() as number:
        body = load(path, number)
        joints = joint_table(body, number)
        for _ in range(4):
            q, values = random_configuration(model, rng)
            pin.framesForwardKinematics(model, data, q)
            for name, value in values.items():
                p.resetJointState(body, joints[name][0], value, physicsClientId=number)
            for index, _, link in joints.values():
                state = p.getLinkState(body, index, computeForwardKinematics=True, physicsClientId=number)
                truth = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
                seen = pin.XYZQUATToSE3(np.array([*state[4], *state[5]]))
                assert np.allclose(seen.homogeneous, truth.homogeneous, atol=2e-6), link


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_masses_agree(path: Path) -> None:
    """The masses that PyBullet uses are those of the file, and Pinocchio's total is their sum."""
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    masses = {link.attrib["name"]: float(link.find("inertial/mass").attrib["value"]) for link in ET.parse(path).iterfind("link")}
    with client() as number:
        body = load(path, number, fixed=False)
        base = p.getBodyInfo(body, physicsClientId=number)[0].decode()
        seen = {base: p.getDynamicsInfo(body, -1, physicsClientId=number)[0]}
        for index, _, link in joint_table(body, number).values():
            seen[link] = p.getDynamicsInfo(body, index, physicsClientId=number)[0]
    assert seen == pytest.approx(masses)
    assert pin.computeTotalMass(model) == pytest.approx(sum(masses.values()))


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_inertias_are_physical(path: Path) -> None:
    """The moments of inertia of every link with mass are positive and obey the triangle inequality."""
    if path in ROBOTS:
        pytest.skip("published numbers")
    for link in ET.parse(path).iterfind("link"):
        values = {k: float(v) for k, v in link.find("inertial/inertia").attrib.items()}
        matrix = np.array([[values["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
        moments = np.linalg.eigvalsh(matrix)
        assert moments[0] > 0.0
        assert moments[2] <= (moments[0] + moments[1]) * 1.001


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_collision_shapes_agree(path: Path) -> None:
    """Number, kind, size and place of the collision shapes of every link agree."""
    model, shapes = geometry(path)
    with client() as number:
        body = load(path, number)
        base = p.getBodyInfo(body, physicsClientId=number)[0].decode()
        links = {base: -1} | {link: index for index, _, link in joint_table(body, number).values()}
        for link, index in links.items():
            frame = model.getFrameId(link, pin.FrameType.BODY)
            ours = [g for g in shapes.geometryObjects if g.parentFrame == frame]
            theirs = p.getCollisionShapeData(body, index, physicsClientId=number)
            assert len(ours) == len(theirs)
            inertial = inertial_place(body, index, number)
            for item, row in zip(ours, theirs, strict=True):
                _assert_same(item, row, inertial * pin.XYZQUATToSE3(np.array([*row[5], *row[6]])), model)


def _assert_same(item: pin.GeometryObject, row: tuple, place: pin.SE3, model: pin.Model) -> None:
    """Compare one shape of Pinocchio with one row of PyBullet."""
    truth = model.frames[item.parentFrame].placement.actInv(item.placement)
    kind = SHAPES.get(type(item.geometry), p.GEOM_MESH)
    assert row[2] == kind
    assert np.allclose(place.homogeneous, truth.homogeneous, atol=2e-6)
    if kind == p.GEOM_BOX:
        assert np.allclose(row[3], 2.0 * item.geometry.halfSide, atol=1e-9)
    elif kind == p.GEOM_CYLINDER:
        assert np.allclose(row[3][:2], [2.0 * item.geometry.halfLength, item.geometry.radius], atol=1e-9)
    elif kind == p.GEOM_SPHERE:
        assert row[3][0] == pytest.approx(item.geometry.radius)


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_bounding_boxes_agree(path: Path) -> None:
    """The boxes around the collision shapes of every link agree at joint values 0; PyBullet's may be looser."""
    model, _ = geometry(path)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    slack = LOOSE.get(path.stem, 0.012)
    with client() as number:
        body = load(path, number)
        base = p.getBodyInfo(body, physicsClientId=number)[0].decode()
        links = {base: -1} | {link: index for index, _, link in joint_table(body, number).values()}
        for link, parts in link_geometry(path).items():
            place = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            low, high = bounds((shape, place * local) for shape, local in parts)
            seen = np.array(p.getAABB(body, links[link], physicsClientId=number))
            assert np.all(seen[0] <= low + 1e-3), link
            assert np.all(seen[1] >= high - 1e-3), link
            assert np.all(seen[0] >= low - slack), link
            assert np.all(seen[1] <= high + slack), link


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_parts_keep_their_colors(path: Path) -> None:
    """Every visual part has the colour that the file gives it, also where a link has several."""
    root = ET.parse(path).getroot()
    with client() as number:
        body = load(path, number)
        base = p.getBodyInfo(body, physicsClientId=number)[0].decode()
        links = {base: -1} | {link: index for index, _, link in joint_table(body, number).values()}
        rows = p.getVisualShapeData(body, physicsClientId=number)
        for link in root.iterfind("link"):
            wanted = [[float(c) for c in e.attrib["rgba"].split()] for e in link.iterfind("visual/material/color")]
            seen = [row[7] for row in rows if row[1] == links[link.attrib["name"]]]
            assert np.allclose(seen, wanted, atol=1e-6)
