"""The arms beside the Panda: names, limits, tip frames, grippers, and which of their links are checked for collisions."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.assets import ASSETS
from rlbench_pin.robot.geometry import gap, link_geometry
from rlbench_pin.robot.self_collisions import sample_disabled_pairs
from rlbench_pin.urdf import disabled_pairs
from tests.assets.support import configuration

OWN_GRIPPER = ("xarm7", "jaco", "iiwa")


@dataclass(frozen=True)
class Facts:
    """What is known of an arm from its maker, and a good configuration."""

    joints: tuple[str, ...]
    speeds: tuple[float, ...]
    """[degrees/s]"""
    torques: tuple[float, ...]
    """[N m]"""
    home: tuple[float, ...]
    tip: tuple[float, float, float]
    """Of the tip at home, in the frame of the base [m]."""
    stretched: tuple[float, ...]
    """Far out, level [rad]."""


UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
ARMS = {
    "ur5e": Facts(
        tuple(f"ur5e_{name}_joint" for name in UR),
        (180.0,) * 6,
        (150.0, 150.0, 150.0, 28.0, 28.0, 28.0),
        (-0.3008, -1.7142, 1.6271, -1.4837, -1.5708, -0.3008),
        (0.45, 0.0, 0.35),
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ),
    "xarm7": Facts(
        tuple(f"xarm7_joint{i}" for i in range(1, 8)),
        (180.0,) * 7,
        (50.0, 50.0, 30.0, 30.0, 30.0, 20.0, 20.0),
        (0.0, -0.2678, 0.0, 1.0433, 0.0, 1.3111, 0.0),
        (0.4, 0.0, 0.35),
        (0.0, 1.5708, 0.0, 0.2, 0.0, 0.0, 0.0),
    ),
    "jaco": Facts(
        tuple(f"jaco_joint_{i}" for i in range(1, 7)),
        (36.0, 36.0, 36.0, 48.0, 48.0, 48.0),
        (40.0, 80.0, 40.0, 20.0, 20.0, 20.0),
        (0.0245, 3.3958, 1.5208, 0.0, 4.4082, 0.0245),
        (0.4, 0.0, 0.35),
        (0.0, 4.7124, 3.1416, 0.0, 3.1416, 0.0),
    ),
    "iiwa": Facts(
        tuple(f"iiwa_joint_{i}" for i in range(1, 8)),
        (98.0, 98.0, 100.0, 130.0, 140.0, 180.0, 180.0),
        (176.0, 176.0, 110.0, 110.0, 110.0, 40.0, 40.0),
        (0.0, 0.319, 0.0, -1.6105, 0.0, 1.2121, 0.0),
        (0.5, 0.0, 0.35),
        (0.0, 1.5708, 0.0, 0.0, 0.0, 0.0, 0.0),
    ),
}


def _file(arm: str, ending: str = "urdf") -> Path:
    return ASSETS / "robots" / arm / f"{arm}.{ending}"


@cache
def _model(arm: str) -> pin.Model:
    return pin.buildModelFromUrdf(str(_file(arm)))


def _at(arm: str, values: tuple[float, ...], gripper: dict[str, float] | None = None) -> np.ndarray:
    """Return the configuration (nq,) of joint values of the arm and of the gripper."""
    return configuration(_model(arm), dict(zip(ARMS[arm].joints, values, strict=True)) | (gripper or {}))


def _places(arm: str, q: np.ndarray) -> dict[str, pin.SE3]:
    """Return the frames of all links in that of the base."""
    model = _model(arm)
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return {f.name: data.oMf[i] for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}


def _linkage(angle: float) -> dict[str, float]:
    """Return the joint values of the 2F-85 at an angle of its drives."""
    values = {"ur5e_finger_joint": angle, "ur5e_right_outer_knuckle_joint": angle}
    for joint in ET.parse(_file("ur5e")).getroot().iterfind("joint[mimic]"):
        mimic = joint.find("mimic")
        values[joint.attrib["name"]] = float(mimic.attrib["multiplier"]) * values[mimic.attrib["joint"]]
    return values


@pytest.mark.parametrize("arm", ARMS)
def test_joints_come_from_base_to_wrist_with_the_limits_of_the_maker(arm: str) -> None:
    """Arm joints are the first ones; speeds and torques are those of the data sheets."""
    model, facts = _model(arm), ARMS[arm]
    count = len(facts.joints)
    assert tuple(model.names)[1 : count + 1] == facts.joints
    assert np.allclose(np.degrees(model.velocityLimit[:count]), facts.speeds, atol=0.1)
    assert np.allclose(model.effortLimit[:count], facts.torques)


def test_ranges_are_those_of_the_makers() -> None:
    """The UR5e turns twice round, its elbow once; the Jaco turns without end; the iiwa as far as its data sheet says."""
    assert np.allclose(_model("ur5e").upperPositionLimit[:6], [2 * np.pi, 2 * np.pi, np.pi, 2 * np.pi, 2 * np.pi, 2 * np.pi])
    kinds = {joint.attrib["name"]: joint.attrib["type"] for joint in ET.parse(_file("jaco")).getroot().iterfind("joint")}
    assert [kinds[name] == "continuous" for name in ARMS["jaco"].joints] == [True, False, False, True, False, True]
    assert np.allclose(np.degrees(_model("iiwa").upperPositionLimit[:7]), [170, 120, 170, 120, 170, 120, 175], atol=1e-5)


@pytest.mark.parametrize("arm", ARMS)
def test_files_have_nothing_of_ros_and_moving_links_have_mass(arm: str) -> None:
    """No packages, transmissions or controllers; every link that moves has a positive mass and inertia."""
    root = ET.parse(_file(arm)).getroot()
    assert {element.tag for element in root} == {"link", "joint"}
    assert all(mesh.attrib["filename"].startswith("meshes/") for mesh in root.iter("mesh"))
    moving = {joint.find("child").attrib["link"] for joint in root.iterfind("joint") if joint.attrib["type"] != "fixed"}
    for link in root.iterfind("link"):
        if link.attrib["name"] in moving:
            assert float(link.find("inertial/mass").attrib["value"]) > 0.0
            values = {key: float(value) for key, value in link.find("inertial/inertia").attrib.items()}
            matrix = np.array([[values["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
            moments = np.linalg.eigvalsh(matrix)
            assert moments[0] > 0.0
            assert moments[2] <= (moments[0] + moments[1]) * 1.001


@pytest.mark.parametrize("arm", ARMS)
def test_the_hand_points_down_at_home(arm: str) -> None:
    """The tip frame is (0, 1, 0, 0) up to sign there, ahead of the base."""
    tip = _places(arm, _at(arm, ARMS[arm].home))[f"{arm}_tip"]
    assert np.allclose(tip.translation, ARMS[arm].tip, atol=1e-3)
    assert np.allclose(tip.rotation, np.diag([-1.0, 1.0, -1.0]), atol=1e-3)


@pytest.mark.parametrize("arm", ARMS)
def test_motors_hold_the_stretched_arm(arm: str) -> None:
    """The torque of gravity is below the limits far out, where it is large, and so is it at home."""
    model, facts = _model(arm), ARMS[arm]
    for values in (facts.stretched, facts.home):
        torques = pin.computeGeneralizedGravity(model, model.createData(), _at(arm, values))
        assert np.all(np.abs(torques[: len(facts.joints)]) < facts.torques)


@pytest.mark.parametrize("arm", ARMS)
def test_nothing_touches_at_home(arm: str) -> None:
    """Links that are checked against each other are apart there, whether the gripper is open or shut."""
    ignored, parts = disabled_pairs(_file(arm, "srdf")), link_geometry(_file(arm))
    shut = dict.fromkeys((f"{arm}_finger_joint1", f"{arm}_finger_joint2"), 0.0) if arm in OWN_GRIPPER else _linkage(0.8)
    wide = dict.fromkeys(shut, 0.04) if arm in OWN_GRIPPER else _linkage(0.0)
    for gripper in (shut, wide):
        places = _places(arm, _at(arm, ARMS[arm].home, gripper))
        for first, second in combinations(sorted(parts), 2):
            if frozenset((first, second)) not in ignored:
                assert gap(parts[first], places[first], parts[second], places[second]) > 0.005, (first, second)


@pytest.mark.parametrize("arm", ARMS)
def test_what_can_meet_is_checked(arm: str) -> None:
    """Hand and fingers are checked against the base and the link above it; neighbours and the gripper's own links are not."""
    ignored, parts = disabled_pairs(_file(arm, "srdf")), link_geometry(_file(arm))
    links = list(parts)
    base, hand = links[0], f"{arm}_hand"
    assert frozenset((base, hand)) not in ignored
    gripper = links[links.index(hand) :]
    assert all(frozenset(pair) in ignored for pair in combinations(gripper, 2))
    assert all(frozenset((a, b)) in ignored for a, b in zip(links, links[1 : links.index(hand) + 1]))
    assert all(link in parts for pair in ignored for link in pair)


def test_disabled_pairs_are_reproducible_and_have_reasons() -> None:
    """Two runs agree; what only joints of the gripper move is ignored as such, what a joint connects as adjacent."""
    first = sample_disabled_pairs(_file("jaco"), 200)
    assert first == sample_disabled_pairs(_file("jaco"), 200)
    reasons = {(a, b): reason for a, b, reason in first}
    assert reasons["jaco_hand", "jaco_link_6"] == "Adjacent"
    assert reasons["jaco_leftfinger", "jaco_rightfinger"] == "Gripper"
    assert reasons["jaco_leftfinger", "jaco_link_6"] == "Gripper"
    assert reasons["jaco_link_1", "jaco_link_3"] == "Never"


@pytest.mark.parametrize("arm", OWN_GRIPPER)
def test_our_gripper_has_the_measures_of_the_panda(arm: str) -> None:
    """Fingers have the same boxes, travel and friction, and the tip is where the Panda's is between them."""
    panda, own = (ET.parse(_file(name)).getroot() for name in ("panda", arm))
    for side in ("leftfinger", "rightfinger"):
        ours, theirs = own.find(f"link[@name='{arm}_{side}']"), panda.find(f"link[@name='panda_{side}']")
        for path in ("collision/geometry/box", "contact/lateral_friction", "contact/spinning_friction", "inertial/mass"):
            a, b = ([e.attrib.get("size", e.attrib.get("value")).split() for e in link.iterfind(path)] for link in (ours, theirs))
            assert np.allclose(np.array(a, dtype=float), np.array(b, dtype=float))
    for number in (1, 2):
        ours = own.find(f"joint[@name='{arm}_finger_joint{number}']/limit")
        theirs = panda.find(f"joint[@name='panda_finger_joint{number}']/limit")
        assert all(float(ours.attrib[key]) == float(theirs.attrib[key]) for key in ("lower", "upper", "effort", "velocity"))
    places = _places(arm, pin.neutral(_model(arm)))
    left = places[f"{arm}_tip"].actInv(places[f"{arm}_leftfinger"])
    assert np.allclose(left.translation, (0.0, 0.0, 0.0584 - 0.1034), atol=1e-6)
    wide = _places(arm, configuration(_model(arm), {f"{arm}_finger_joint1": 0.04}))
    assert wide[f"{arm}_tip"].actInv(wide[f"{arm}_leftfinger"]).translation[1] == pytest.approx(-0.04)


@pytest.mark.parametrize("angle", (0.0, 0.4, 0.8))
def test_the_pads_of_the_2f_85_stay_parallel_and_meet(angle: float) -> None:
    """They are 85 mm apart when open, touch when shut, and end 9.5 mm beyond the tip when nearly shut, as the Panda's."""
    shape, T_finger_pad = link_geometry(_file("ur5e"))["ur5e_left_inner_finger"][0]
    places = _places("ur5e", _at("ur5e", ARMS["ur5e"].home, _linkage(angle)))
    tip = places["ur5e_tip"]
    pads = [tip.actInv(places[f"ur5e_{side}_inner_finger"] * T_finger_pad) for side in ("left", "right")]
    assert all(np.allclose(pad.rotation[:, 2], (0.0, 0.0, 1.0), atol=1e-6) for pad in pads)
    apart = pads[1].translation[1] - pads[0].translation[1] - 2.0 * shape.halfSide[1]
    assert apart == pytest.approx({0.0: 0.0845, 0.4: 0.0451, 0.8: 0.0}[angle], abs=2e-4)
    end = pads[0].translation[2] + shape.halfSide[2]
    assert end == pytest.approx({0.0: -0.0046, 0.4: 0.0066, 0.8: 0.0093}[angle], abs=3e-4)


def test_the_linkage_of_the_2f_85_says_who_follows_whom() -> None:
    """Two drives without `<mimic>`, and four joints that follow the drive of their side."""
    joints = {joint.attrib["name"]: joint for joint in ET.parse(_file("ur5e")).getroot().iterfind("joint[@type='revolute']")}
    own = {name: joint.find("mimic") for name, joint in joints.items() if name not in ARMS["ur5e"].joints}
    followers = {name: (m.attrib["joint"], float(m.attrib["multiplier"])) for name, m in own.items() if m is not None}
    assert followers == {
        "ur5e_left_inner_finger_joint": ("ur5e_finger_joint", -1.0),
        "ur5e_left_inner_knuckle_joint": ("ur5e_finger_joint", 1.0),
        "ur5e_right_inner_finger_joint": ("ur5e_right_outer_knuckle_joint", -1.0),
        "ur5e_right_inner_knuckle_joint": ("ur5e_right_outer_knuckle_joint", 1.0),
    }
    assert set(own) - set(followers) == {"ur5e_finger_joint", "ur5e_right_outer_knuckle_joint"}
    assert math.isclose(float(joints["ur5e_finger_joint"].find("limit").attrib["upper"]), 0.8)
