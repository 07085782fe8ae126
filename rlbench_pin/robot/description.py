"""Descriptions of arms: files, names in a fixed order, home configuration, and values that are not in the URDF.

All data of an arm is in its record; to add an arm, add a record.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import InvalidValue, RobotModelError, UnknownName, nearest_name
from rlbench_pin.spatial import TABLE_HEIGHT
from rlbench_pin.values import POSITIVE, Rule, as_number, as_path, as_pose, as_text, as_vector, as_whole, items_of

# In front of the gripper, pitched 0.4 rad towards the fingers; at home the top of the image is away from the base.
HAND_CAMERA = (0.08, 0.0, 0.03, 0.1404802, -0.1404802, -0.6930117, 0.6930117)
"""Pose (7,) of the wrist camera in a hand link whose z axis points out and whose y axis is the direction of the fingers."""


@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """One arm with its gripper. Joint names are in the order of all public joint vectors."""

    name: str
    """Catalogue name, lower case."""
    urdf: Path
    """Model file with visual and collision geometry, for PyBullet and Pinocchio."""
    srdf: Path
    """Pairs of links whose collisions are ignored."""
    arm_joints: tuple[str, ...]
    """Arm joints from base to wrist."""
    gripper_joints: tuple[str, ...]
    """Drive joints of the fingers, first and second; may be empty for planning and control. Joints that follow them are
    marked `<mimic>` in the URDF."""
    tip_frame: str
    """Frame between the finger pads, z out of the gripper, y from the first finger to the second."""
    hand_link: str
    """Link that carries the fingers; grasped bodies are fixed to it."""
    finger_links: tuple[str, ...]
    """Links of the pads, first and second."""
    camera_pose: tuple[float, float, float, float, float, float, float]
    """Wrist camera in the frame of `hand_link`, camera z forward, x left, y up."""
    home: tuple[float, ...]
    """Arm configuration at the start of an episode [rad]."""
    base_pose: tuple[float, float, float, float, float, float, float]
    """Pose of the base link in the world."""
    gripper_open: float
    """Distance of each pad from the middle when the gripper is open [m]; 0 is closed."""
    gripper_force: float
    """Largest force of one finger [N]."""
    finger_speed: float
    """Finger speed of gripper actions [m/s]."""
    grip_speed: float
    """Finger speed when closing [m/s]: fast fingers push light objects away."""
    pad_friction: float
    """Friction coefficient of the pads; the coefficient of a contact is its product with that of the object."""
    pad_size: tuple[float, float]
    """Size along tip x and z of the box between the pads; bodies in this box are between the fingers [m]."""
    acceleration: tuple[float, ...]
    """Acceleration limit of each arm joint [rad/s^2]."""
    reach: float
    """Upper bound of the distance of the arm and held bodies from the base [m]."""
    linear_speed: float
    """Largest linear speed of the tip in an action [m/s]."""
    angular_speed: float
    """Largest angular speed of the tip in an action [rad/s]."""
    loaded_joints: int
    """Number of joints at the base that carry the weight of the arm; they may reach a commanded velocity only after a tick."""
    loaded_share: float
    """Usable fraction of the acceleration limit of `loaded_joints` while their torque compensates gravity."""
    joint_stiffness: tuple[float, ...]
    """Stiffness of joint impedance control [N m/rad]: softer than the position control of the motors."""
    file: Path | None = None
    """TOML file that describes the arm; None for an arm of the catalogue."""

    @property
    def reference(self) -> str:
        """Reference to the arm for other processes: its name in the catalogue, or the absolute path of its file."""
        return self.name if self.file is None else str(self.file)

    def __post_init__(self) -> None:
        """Raise RobotModelError for a vector without one value per arm joint."""
        for name in ("home", "acceleration", "joint_stiffness"):
            count = len(getattr(self, name))
            if count != len(self.arm_joints):
                raise RobotModelError(
                    f"'{self.name}' has {len(self.arm_joints)} arm joints, but {count} numbers in '{name}'. "
                    "Pass one number per joint."
                )


class UnknownRobot(UnknownName, ValueError):
    """There is no arm with this name in the catalogue."""


class RobotFileError(RobotModelError, ValueError):
    """A TOML file is not a valid description of an arm; `file` and `key` locate the error."""

    def __init__(self, file: Path | str, key: str, problem: str, hint: str = "") -> None:
        self.file, self.key, self.problem = Path(file), key, problem
        where = f", key '{key}'" if key else ""
        super().__init__(f"'{self.file}'{where}: {problem}{f' {hint}' if hint else ''}")


def _panda() -> RobotDescription:
    """Franka Emika Panda with its parallel gripper, mounted on the table behind the workspace."""
    return RobotDescription(
        name="panda",
        urdf=asset_path("robots/panda/panda.urdf"),
        srdf=asset_path("robots/panda/panda.srdf"),
        arm_joints=tuple(f"panda_joint{i}" for i in range(1, 8)),
        gripper_joints=("panda_finger_joint1", "panda_finger_joint2"),
        tip_frame="panda_hand_tcp",
        hand_link="panda_hand",
        finger_links=("panda_leftfinger", "panda_rightfinger"),
        camera_pose=HAND_CAMERA,
        home=(0.0, 0.175, 0.0, -0.873, 0.0, 1.222, 0.785),
        base_pose=(-0.273, 0.0, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0),
        gripper_open=0.04,
        gripper_force=40.0,
        finger_speed=0.2,
        grip_speed=0.04,
        pad_friction=1.0,
        pad_size=(0.012, 0.012),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        reach=1.6,  # 1.2 m, and what the gripper holds
        linear_speed=1.7,
        angular_speed=2.5,
        loaded_joints=2,
        loaded_share=0.65,
        joint_stiffness=(600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
    )


def _with_our_gripper(name: str, arm_joints: tuple[str, ...], **numbers: Any) -> RobotDescription:
    """Return an arm whose model has no gripper, with a parallel gripper of the dimensions of the Panda's."""
    return replace(
        _panda(),
        name=name,
        urdf=asset_path(f"robots/{name}/{name}.urdf"),
        srdf=asset_path(f"robots/{name}/{name}.srdf"),
        arm_joints=arm_joints,
        gripper_joints=(f"{name}_finger_joint1", f"{name}_finger_joint2"),
        tip_frame=f"{name}_tip",
        hand_link=f"{name}_hand",
        finger_links=(f"{name}_leftfinger", f"{name}_rightfinger"),
        **numbers,
    )


def _ur5e() -> RobotDescription:
    """Universal Robots UR5e with a Robotiq 2F-85; limits of its data sheet, accelerations that its drives reach with 5 kg.

    The pads are of silicone rubber. MuJoCo Menagerie's model of the 2F-85 has a friction of 0.7 at their ends, where objects are
    gripped, and 0.6 behind; the manuals of the manufacturer use 0.3 for silicone on steel with cutting oil.
    """
    joints = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    return replace(
        _panda(),
        name="ur5e",
        urdf=asset_path("robots/ur5e/ur5e.urdf"),
        srdf=asset_path("robots/ur5e/ur5e.srdf"),
        arm_joints=tuple(f"ur5e_{joint}_joint" for joint in joints),
        gripper_joints=("ur5e_finger_joint", "ur5e_right_outer_knuckle_joint"),
        tip_frame="ur5e_tip",
        hand_link="ur5e_hand",
        finger_links=("ur5e_left_inner_finger", "ur5e_right_inner_finger"),
        home=(-0.274, -1.565, 1.245, -1.251, -1.571, -0.274),
        gripper_open=0.042,
        gripper_force=60.0,
        pad_friction=0.7,
        pad_size=(0.014, 0.014),
        acceleration=(10.0, 10.0, 12.0, 15.0, 15.0, 15.0),
        joint_stiffness=(600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
    )


def _xarm7() -> RobotDescription:
    """UFACTORY xArm7; its manufacturer allows 20 rad/s^2."""
    return _with_our_gripper(
        "xarm7",
        tuple(f"xarm7_joint{i}" for i in range(1, 8)),
        home=(0.0, 0.09, 0.0, 1.711, 0.0, 1.62, 0.0),
        acceleration=(10.0, 10.0, 12.0, 12.0, 15.0, 15.0, 20.0),
    )


def _iiwa() -> RobotDescription:
    """KUKA LBR iiwa 7 R800."""
    return _with_our_gripper(
        "iiwa",
        tuple(f"iiwa_joint_{i}" for i in range(1, 8)),
        home=(0.0, 0.243, 0.0, -1.455, 0.0, 1.443, 0.0),
        acceleration=(10.0, 7.5, 10.0, 10.0, 15.0, 20.0, 20.0),
    )


def _jaco() -> RobotDescription:
    """Kinova Jaco j2s6s200, a slow arm with six joints."""
    return _with_our_gripper(
        "jaco",
        tuple(f"jaco_joint_{i}" for i in range(1, 7)),
        home=(0.02, 3.607, 2.149, 3.142, 1.457, -3.122),
        acceleration=(4.0, 4.0, 4.0, 6.0, 6.0, 6.0),
        joint_stiffness=(600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
    )


class _Catalogue(Mapping[str, RobotDescription]):
    """Names of arms -> descriptions, each built at its first use."""

    def __init__(self, builders: Mapping[str, Callable[[], RobotDescription]]) -> None:
        self._builders = dict(builders)
        self._built: dict[str, RobotDescription] = {}

    def __getitem__(self, name: str) -> RobotDescription:
        if name not in self._built:
            self._built[name] = self._builders[name]()
        return self._built[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._builders)

    def __len__(self) -> int:
        return len(self._builders)


_ARMS = {"panda": _panda, "ur5e": _ur5e, "xarm7": _xarm7, "iiwa": _iiwa, "jaco": _jaco}
SUPPORTED_ROBOTS: Mapping[str, RobotDescription] = _Catalogue(_ARMS)
DEFAULT_ROBOT = "panda"
"""Name of the default arm."""


def robot_description(name: str | PathLike[str]) -> RobotDescription:
    """Return the description of an arm.

    Args:
        name: A name of the catalogue (case is ignored), or the path of a TOML file; the catalogue takes precedence.

    Raises:
        UnknownRobot: The catalogue has no such arm, and it is not the path of a TOML file (also a ValueError).
        RobotFileError: The file is not a valid description of an arm (also a ValueError).
    """
    text = fspath(name) if isinstance(name, str | PathLike) else ""
    key = text.lower() if isinstance(text, str) else ""
    if key in SUPPORTED_ROBOTS:
        return SUPPORTED_ROBOTS[key]
    if key.endswith(".toml"):
        return read_description(Path(text))
    raise UnknownRobot("robot", name, tuple(SUPPORTED_ROBOTS))  # type: ignore[arg-type]  # says so of anything else, too


# Files --------------------------------------------------------------------------------------------------------------

ROBOT_NAME = re.compile("[a-z][a-z0-9_]{0,39}")
"""Names of arms."""
_NAME_RULE = "has to consist of lower case letters, digits and `_`, and to begin with a letter"


def read_description(file: Path) -> RobotDescription:
    """Return the arm of a TOML file. Its keys are the fields of `RobotDescription`; paths are relative to the file.

    Raises:
        RobotFileError: The file is missing or not TOML, a key is unknown or missing, or a value is invalid.
    """
    try:
        file = as_path(file, "robot", InvalidValue).absolute()
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise RobotFileError(file, "", "does not exist.", "`rlbench-pin arm new NAME --urdf FILE` creates one.") from error
    except (OSError, ValueError) as error:  # decoding and TOML errors are ValueErrors
        raise RobotFileError(file, "", f"cannot be read as TOML: {error}.") from error
    known = tuple(field.name for field in fields(RobotDescription) if field.name != "file")
    for key in content:
        if key not in known:
            near = nearest_name(key, known)
            raise RobotFileError(file, key, "is unknown.", f"Did you mean '{near}'?" if near else f"Keys: {', '.join(known)}.")
    for key in known:
        if key not in content:
            raise RobotFileError(file, key, "is missing.", _example(key))
    size = len(items_of(content["arm_joints"]))
    rules = _rules(file.parent, size)
    values: dict[str, Any] = {}
    for key in known:
        try:
            values[key] = rules[key](content[key], key)
        except InvalidValue as error:
            hint = "" if error.hint else _example(key)
            raise RobotFileError(file, key, str(error).removeprefix(f"{key} "), hint) from error
    return RobotDescription(**values, file=file)


def _example(key: str) -> str:
    """Return the line of the Panda for a key, as a hint."""
    value = getattr(_panda(), key)
    if isinstance(value, Path):
        return f'Give a path relative to the file, such as {key} = "my_arm{value.suffix}".'
    items = ", ".join(f'"{item}"' if isinstance(item, str) else f"{item:g}" for item in value) if isinstance(value, tuple) else ""
    text = f"[{items}]" if items else f'"{value}"' if isinstance(value, str) else f"{value:g}"
    return f"The Panda has {key} = {text}."


def _rules(folder: Path, size: int) -> dict[str, Rule]:
    """Return the rule of each key of a file in a folder, for an arm of `size` joints."""
    share, whole = partial(as_number, above=0.0, most=1.0), partial(as_whole, least=0, most=size)
    per_joint = partial(_numbers, size=size, positive=True)
    return {
        "name": _as_robot_name,
        "urdf": partial(_as_file, folder=folder),
        "srdf": partial(_as_file, folder=folder),
        "arm_joints": partial(_as_texts, counts=range(1, 33)),
        "gripper_joints": partial(_as_texts, counts=(0, 2)),
        "tip_frame": as_text,
        "hand_link": as_text,
        "finger_links": partial(_as_texts, counts=(0, 2)),
        "camera_pose": _as_pose,
        "home": partial(_numbers, size=size),
        "base_pose": _as_pose,
        **dict.fromkeys(("gripper_open", "gripper_force", "finger_speed", "grip_speed"), partial(as_number, least=0.0)),
        "pad_size": partial(_numbers, size=2, positive=True),
        "acceleration": per_joint,
        **dict.fromkeys(("pad_friction", "reach", "linear_speed", "angular_speed"), POSITIVE),
        "loaded_joints": whole,
        "loaded_share": share,
        "joint_stiffness": per_joint,
    }


def _as_robot_name(value: object, what: str) -> str:
    name = as_text(value, what)
    if not ROBOT_NAME.fullmatch(name):
        raise InvalidValue(what, value, _NAME_RULE)
    if name in SUPPORTED_ROBOTS:
        raise InvalidValue(what, value, "is an arm of the catalogue", "Choose another name.")
    return name


def _as_file(value: object, what: str, folder: Path) -> Path:
    path = folder / as_path(as_text(value, what), what)
    if not path.is_file():
        raise InvalidValue(what, value, f"has to be an existing file; '{path}' does not exist")
    return path


def _as_texts(value: object, what: str, counts: range | tuple[int, ...]) -> tuple[str, ...]:
    texts = tuple(item for item in items_of(value) if isinstance(item, str) and item)
    if len(texts) != len(items_of(value)) or len(texts) not in counts or not isinstance(value, list):
        number = f"{counts[0]} or {counts[-1]}" if isinstance(counts, tuple) else f"{counts[0]} to {counts[-1]}"
        raise InvalidValue(what, value, f"has to be a list of {number} names")
    if len(set(texts)) < len(texts):
        raise InvalidValue(what, value, "contains a name twice")
    return texts


def _as_pose(value: object, what: str) -> tuple[float, ...]:
    return tuple(as_pose(value, what, tolerance=1e-3).tolist())  # type: ignore[arg-type]


def _numbers(value: object, what: str, size: int, positive: bool = False) -> tuple[float, ...]:
    numbers = tuple(as_vector(value, size, what).tolist())  # type: ignore[arg-type]
    if positive and min(numbers, default=1.0) <= 0.0:
        raise InvalidValue(what, value, "has to consist of numbers above 0")
    return numbers
