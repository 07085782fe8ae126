"""Writer of the folder of a user's arm: URDF, meshes, SRDF of sampled pairs, and TOML file with a collision-free home."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rlbench_pin.builder.custom_assets.arm_urdf import (
    GRIPPER_OF,
    Gripper,
    arm_asset,
    changed,
    fixed_joint,
    gripper_asset,
    joined,
    shared_gripper,
)
from rlbench_pin.builder.custom_assets.folder import Folder
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset, format_numbers
from rlbench_pin.builder.custom_assets.urdf_asset import OnNote
from rlbench_pin.errors import PlanningError, RobotModelError, TaskEnvironmentError
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.robot import SUPPORTED_ROBOTS, CollisionModel, RobotDescription, RobotModel, robot_description
from rlbench_pin.robot.description import ROBOT_NAME
from rlbench_pin.robot.mounting import FingerLayout, Mount, finger_layout, flange_mount, joints_to
from rlbench_pin.robot.self_collisions import srdf_text
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, above_table
from rlbench_pin.urdf import read_urdf

STEPS = 6
"""Steps that `make_arm` names."""
BASES = tuple((x, z) for z in (0.0, 0.1, 0.2) for x in (-0.273, -0.22, -0.17, -0.12))
"""Places of the base: x, and height over the table [m]; the Panda's first. A short arm stands nearer, or on a pedestal."""
ACCELERATION = 5.0
"""Acceleration limit of joints where nothing is known [rad/s^2]."""
MISSING = "not in the URDF: take it from the data sheet"
TURNS = (0.0, np.pi, 0.5 * np.pi, -0.5 * np.pi)
"""How the gripper may be turned on the flange [rad]; the first that reaches most is taken."""
_DOWN = (0.0, 1.0, 0.0, 0.0)
_GRID = tuple((x, y, z) for x in (0.12, 0.25, 0.38) for y in (-0.25, 0.0, 0.25) for z in (0.04, 0.2))
"""Places of the tip above the table that tasks use [m]."""
_CLEAR = 0.03
"""Height of joints over the table at home at least [m]."""
_MARGIN = 0.25
"""Distance from the joint limits that is enough at home [rad]."""
_HELD = 0.4
"""An object in the gripper reaches farther from the base than the tip by at most this [m]."""
_ASSUMED = {"acceleration": f"[rad/s^2] {MISSING}"}
"""Keys that no URDF gives, with the remark on their line."""
_OF_GRIPPER = {"gripper_force": f"[N] {MISSING}", "finger_speed": f"[m/s] {MISSING}"}
"""Such keys of a gripper."""
_GRIPPER_KEYS = ("gripper_force", "finger_speed", "grip_speed", "pad_friction", "pad_size")
"""Keys with which other grippers begin as the shared one."""


@dataclass(frozen=True)
class NewArm:
    """A written arm."""

    file: Path
    """Its TOML file."""
    description: RobotDescription
    """The arm."""
    flange: str
    """Link that carries the gripper."""
    mount: Mount
    """Place of the gripper in it."""
    reached: tuple[int, int]
    """Places above the table that the gripper reaches from above, and how many were tried."""
    missing: tuple[str, ...]
    """Numbers that the URDF does not give, one line each."""


def make_arm(
    name: str,
    urdf: Path,
    out: Path,
    gripper: Path | None = None,
    flange: str = "",
    mount: Sequence[float] | None = None,
    note: OnNote = lambda _: None,
) -> NewArm:
    """Write the folder `name` in `out`: all files of an arm from a URDF file.

    Args:
        name: Name of the arm.
        urdf: URDF file of the arm.
        out: Folder in which the new folder is made.
        gripper: URDF file of a gripper; None is the parallel gripper of the xArm7, iiwa and Jaco.
        flange: Link that carries the gripper; empty for the last link.
        mount: Pose of the gripper in the flange: x, y, z [m], roll, pitch, yaw [rad]; None determines it.
        note: Called with each of `STEPS` steps.

    Raises:
        TaskEnvironmentError: The name cannot be used, or the folder exists.
        UploadRefused: A URDF file or a mesh cannot be used.
        RobotModelError: The gripper does not have two fingers, or no home was found.
        StorageError: The folder cannot be written.
    """
    _check_name(name, out)
    note("reading the arm")
    arm, flange, missing = arm_asset(name, urdf, flange, lambda _: None)
    note("reading the gripper")
    with tempfile.TemporaryDirectory() as folder:
        held = shared_gripper(name) if gripper is None else gripper_asset(name, gripper, lambda _: None)
        place = flange_mount(_written(Path(folder, "arm"), arm), flange) if mount is None else Mount(*np.reshape(mount, (2, 3)))
        if gripper is None:
            numbers = _shared_numbers(name, held.base)
        else:
            layout = finger_layout(_written(Path(folder, "gripper"), held.asset))
            held, numbers = _with_tip(name, held, layout), _gripper_numbers(name, held.base, layout)
        note("placing base and gripper")
        file = _written(Path(folder, "first"), joined(name, arm, flange, held, place))
        placed, turn, reached = _placed(_described(name, file, numbers), TURNS if mount is None else TURNS[:1])
        place = place.turned(turn)
        whole = joined(name, arm, flange, held, place)
        note("sampling which links can touch")
        file = _written(Path(folder, "whole"), whole)
        srdf = file.with_suffix(".srdf")
        srdf.write_text(srdf_text(file), encoding="utf-8")
        note("looking for a home")
        description = replace(placed, urdf=file, srdf=srdf)
        description = replace(description, home=_home(description))
        note("writing")
        assumed = _ASSUMED | (_OF_GRIPPER if gripper is not None else {})
        files = {
            **whole.files,
            srdf.name: srdf.read_bytes(),
            f"{name}.toml": _toml(description, urdf.name, assumed, missing).encode(),
        }
    out.mkdir(parents=True, exist_ok=True)
    written = Folder(out).write_all(name, files) / f"{name}.toml"
    lines = [f"{key} = {_value(getattr(description, key))} {unit}" for key, unit in assumed.items()]
    return NewArm(written, robot_description(written), flange, place, reached, (*lines, *missing))


def _check_name(name: str, out: Path) -> None:
    if not ROBOT_NAME.fullmatch(name):
        raise TaskEnvironmentError(f"'{name}' is not a name of an arm. Use lower case letters, digits and `_`, a letter first.")
    if name in SUPPORTED_ROBOTS:
        raise TaskEnvironmentError(f"'{name}' is an arm of the catalogue. Choose another name.")
    if (out / name).exists():
        raise TaskEnvironmentError(f"'{out / name}' exists. Choose another name, give another folder with --out, or remove it.")


def _written(folder: Path, asset: CustomAsset) -> Path:
    """Write an asset to a temporary folder and return its URDF file."""
    for file, content in asset.files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_bytes(content)
    return folder / asset.urdf


# Grippers -----------------------------------------------------------------------------------------------------------


def _shared_numbers(name: str, hand: str) -> dict[str, Any]:
    """Return the keys of the shared gripper, with the names for this arm."""
    known = robot_description(GRIPPER_OF)
    keys = ("gripper_joints", "finger_links", "tip_frame", "camera_pose", "gripper_open", *_GRIPPER_KEYS)
    values = {key: getattr(known, key) for key in keys}

    def renamed(text: str) -> str:
        return name + text.removeprefix(GRIPPER_OF)

    links = {key: tuple(map(renamed, values[key])) for key in ("gripper_joints", "finger_links")}
    return {**values, **links, "tip_frame": renamed(values["tip_frame"]), "hand_link": hand}


def _gripper_numbers(name: str, hand: str, layout: FingerLayout) -> dict[str, Any]:
    return {
        "gripper_joints": layout.drives,
        "finger_links": layout.pads,
        "tip_frame": f"{name}_tip",
        "hand_link": hand,
        "camera_pose": tuple(layout.camera.tolist()),
        "gripper_open": layout.opening,
        **{key: getattr(robot_description(GRIPPER_OF), key) for key in _GRIPPER_KEYS},
    }


def _with_tip(name: str, gripper: Gripper, layout: FingerLayout) -> Gripper:
    """Return a gripper with a tip frame and independent drives; its prismatic joints are 0 when it is closed."""

    def change(root: Element) -> None:
        inertial = SubElement(SubElement(root, "link", name=f"{name}_tip"), "inertial")  # PyBullet gives a link without one 1 kg
        SubElement(inertial, "mass", value="0")
        SubElement(inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
        root.append(fixed_joint(f"{name}_tip_joint", gripper.base, f"{name}_tip", layout.tip))
        for joint in root.iterfind("joint"):
            key = joint.get("name", "")
            way, mimic = layout.follows.get(key), joint.find("mimic")
            if mimic is not None:
                joint.remove(mimic)
            if way is not None:
                SubElement(joint, "mimic", joint=way.joint, multiplier=f"{way.ratio:.9g}", offset=f"{way.offset:.9g}")
        for slide in layout.slides:
            _from_shut(
                next(j for j in root.iterfind("joint") if j.get("name") == slide.joint), slide.shut, slide.sign, slide.travel
            )

    return replace(gripper, asset=changed(gripper.asset, change))


def _from_shut(joint: Element, shut: float, sign: float, travel: float) -> None:
    """Shift the positions of a prismatic joint, so that they count from closed to open."""
    origin, axis, limit = joint.find("origin"), joint.find("axis"), joint.find("limit")
    assert origin is not None and axis is not None and limit is not None
    xyz, rpy, along = (
        np.array(text.split(), dtype=float) for text in (origin.attrib["xyz"], origin.attrib["rpy"], axis.attrib["xyz"])
    )
    origin.set("xyz", format_numbers(xyz + _rotation(rpy) @ along * shut))
    axis.set("xyz", " ".join(f"{sign * number:g}" for number in along))
    limit.attrib.update({"lower": "0", "upper": f"{travel:.9g}"})


def _rotation(rpy: FloatArray) -> FloatArray:
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    turns = (
        [[1, 0, 0], [0, cr, -sr], [0, sr, cr]],
        [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]],
        [[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]],
    )
    x, y, z = (np.array(turn) for turn in turns)
    result: FloatArray = z @ y @ x
    return result


# Numbers of the arm -------------------------------------------------------------------------------------------------


def _described(name: str, urdf: Path, gripper: dict[str, Any]) -> RobotDescription:
    """Return the arm with the base of the Panda, in the middle of its joint ranges."""
    model = read_urdf(urdf)
    chain = joints_to(model, gripper["hand_link"])
    arm = [joint for joint in chain if joint.kind != "fixed"]
    lengths = [np.linalg.norm(joint.origin.xyz) for joint in chain[1:] if joint.origin is not None]
    wrist = (250.0, 150.0, 50.0)[-len(arm) :]
    panda = robot_description("panda")
    middle = [0.0 if np.isinf(joint.limits[0]) else float(np.clip(0.0, *joint.limits)) for joint in arm]
    return RobotDescription(
        **gripper,
        name=name,
        urdf=urdf,
        srdf=urdf.with_suffix(".srdf"),
        arm_joints=tuple(joint.name for joint in arm),
        home=tuple(middle),
        base_pose=(*panda.base_pose[:2], TABLE_HEIGHT, *panda.base_pose[3:]),
        acceleration=(ACCELERATION,) * len(arm),
        reach=round(float(np.sum(lengths)) + _HELD, 2),
        linear_speed=1.0,
        angular_speed=panda.angular_speed,
        loaded_joints=min(panda.loaded_joints, len(arm)),
        loaded_share=panda.loaded_share,
        joint_stiffness=(600.0,) * (len(arm) - len(wrist)) + wrist,
    )


def _placed(description: RobotDescription, turns: Sequence[float]) -> tuple[RobotDescription, float, tuple[int, int]]:
    """Return the arm at the base pose from which it reaches most of the workspace from above.

    Args:
        description: The arm.
        turns: Possible angles of the gripper about the z axis of the flange [rad].

    Returns:
        The arm at its base pose, the angle, the number of reached positions, and the number of all positions.
    """
    best, turned, most = description, 0.0, -1
    for x, z in BASES:
        placed = replace(description, base_pose=(x, 0.0, above_table(z), 0.0, 0.0, 0.0, 1.0))
        for turn in turns:
            count = _reached(placed, turn)
            if count > most:
                best, turned, most = placed, turn, count
            if count == len(_GRID):
                return best, turned, (most, most)
        turns = (turned,)
    return best, turned, (most, len(_GRID))


def _reached(description: RobotDescription, turn: float) -> int:
    """Return the number of positions of the workspace that the gripper reaches from above at an angle on the flange."""
    model, rng = RobotModel(description), np.random.default_rng(0)
    count, q = 0, model.home
    down = (-np.sin(0.5 * turn), np.cos(0.5 * turn), 0.0, 0.0)  # the half turn about y, after the turn was undone
    for x, y, z in _GRID:
        with suppress(PlanningError):
            q = solve_ik(model, (x, y, above_table(z), *down), q, rng, starts=10)[0]
            count += 1
    return count


def _home(description: RobotDescription) -> tuple[float, ...]:
    """Return a collision-free configuration that points down near the home of the Panda's tip, far from limits and singularities.

    Raises:
        RobotModelError: There is none, also nearer to the base and lower.
    """
    model, panda = RobotModel(description), RobotModel(robot_description("panda"))
    collision, rng = CollisionModel(model), np.random.default_rng(0)
    best, most = None, 0.0
    x, y, z = panda.tip_pose(panda.home)[:3].tolist()
    for place in _nearer(x, y, z, description.base_pose[0]):
        with suppress(PlanningError):
            for q in solve_ik(model, (*place, *_DOWN), model.home, rng, starts=30, max_solutions=8, collision=collision):
                margin = min(model.limits.margin(q), _MARGIN)
                score = margin * (model.manipulability(q) + 1e-3)
                if score > most and min(pose[2] for pose in model.joint_poses(q)[1:]) > TABLE_HEIGHT + _CLEAR:
                    best, most = q, score
        if best is not None and model.limits.margin(best) >= _MARGIN:
            break
    if best is not None:
        return tuple((np.round(model.limits.nearest_turn(best, np.zeros(model.size)), 4) + 0.0).tolist())
    raise RobotModelError(
        f"'{description.name}' cannot point its gripper down in front of its base without a collision. Check that the gripper "
        "is on the right link (--flange), and that its z axis points outwards (--mount)."
    )


def _nearer(x: float, y: float, z: float, base: float) -> Iterator[tuple[float, float, float]]:
    """Yield the home position of the Panda's tip, then positions nearer to the base, then lower ones."""
    while z > TABLE_HEIGHT + 0.15:
        for share in (1.0, 0.85, 0.7):
            yield base + share * (x - base), y, z
        z -= 0.1


# TOML ---------------------------------------------------------------------------------------------------------------


def _toml(description: RobotDescription, source: str, assumed: dict[str, str], missing: Sequence[str]) -> str:
    lines = [
        f"# {description.name}, made by `rlbench-pin arm new` of {source}. Keys are the fields of `RobotDescription`,",
        "# units are m, rad, s, kg, N. Position limits, speeds and torques of the joints are in the URDF.",
        *(f"# {line}: {MISSING}" for line in missing),
    ]
    for key in (field.name for field in fields(description) if field.name != "file"):
        value = getattr(description, key)
        text = f'"{value.name}"' if isinstance(value, Path) else _value(value)
        lines.append(f"{key} = {text}" + (f"  # {assumed[key]}" if key in assumed else ""))
    return "\n".join(lines) + "\n"


def _value(value: object) -> str:
    """Return a value as TOML."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_value, value))}]"
    return f'"{value}"' if isinstance(value, str) else repr(round(value, 7)) if isinstance(value, float) else str(value)
