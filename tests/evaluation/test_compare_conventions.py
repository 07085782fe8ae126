"""The convention that a policy uses is recognised by its first actions, whatever its mapping or action mode states."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.environment import (
    ArmActionMode,
    Discrete,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    ERJointViaIK,
    GripperActionMode,
    GripperJointPosition,
    JointPosition,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    SafeArm,
)
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.evaluation.conventions import ConventionReport, compare_conventions
from rlbench_pin.evaluation.policies import PolicyFault
from rlbench_pin.evaluation.policies.mapping import ROTATIONS
from rlbench_pin.evaluation.policies.wires import decode_frame, encode_openpi
from rlbench_pin.observation import Observation
from tests.cli.support import exit_code
from tests.evaluation.policies.policies_with_conventions import Conventional, arm_numbers
from tests.evaluation.policies.served import served

pytestmark = pytest.mark.simulation
FILE = Path(__file__).parent / "policies" / "policies_with_conventions.py"

# Action modes -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stated", "convention", "says"),
    [
        ("absolute", "absolute quaternion_xyzw", "agrees: absolute_pose, quaternion_xyzw."),
        ("absolute", "absolute quaternion_wxyz", "seems to be absolute_pose, quaternion_wxyz, but the action mode states"),
        ("absolute", "world quaternion_xyzw", "seems to be delta_pose, quaternion_xyzw, world frame, but the action mode states"),
        ("absolute", "joint_positions", "seems to be joint_positions, but "),
        ("delta", "world quaternion_xyzw", "agrees: delta_pose, quaternion_xyzw, world frame."),
        ("delta", "world quaternion_wxyz", "seems to be delta_pose, quaternion_wxyz, world frame, but "),
        ("delta", "tip quaternion_xyzw", "seems to be delta_pose, quaternion_xyzw, tip frame, but "),
        ("delta", "absolute quaternion_xyzw", "seems to be absolute_pose, quaternion_xyzw, but "),
        ("joints", "joint_positions", "agrees: joint_positions."),
        ("joints", "joint_deltas", "seems to be joint_velocities, but "),  # small numbers: not told apart from deltas
        ("joints", "joint_velocities", "seems to be joint_velocities, but "),
        ("velocities", "joint_velocities", "agrees: joint_velocities."),
        ("velocities", "joint_positions", "seems to be joint_positions, but "),
    ],
)
def test_a_convention_is_recognised(stated: str, convention: str, says: str) -> None:
    """The best one is the first of the list, and one that differs is said with the stated one."""
    policy = Conventional(stated, convention)
    report = compare_conventions(policy)
    assert report.arm_verdict.text.startswith(says)
    assert report.differs == report.arm_verdict.differs == says.startswith("seems")
    assert report.gripper_verdict.text == "agrees: 1 open, 0 closed."
    assert policy.resets == 3
    scores = [reading.score for reading in report.arm]
    assert scores == sorted(scores, key=lambda score: round(score, 4))
    assert sum(report.is_stated(reading) for reading in report.arm) == 1


def test_how_far_the_first_action_is() -> None:
    """2 cm and the length of a rotation vector; read as w, x, y, z it is the same place and another rotation."""
    report = compare_conventions(Conventional("absolute", "absolute quaternion_xyzw"))
    best, second = (next(r for r in report.arm if r.name.endswith(layout)) for layout in ("quaternion_xyzw", "quaternion_wxyz"))
    assert best.distance == pytest.approx(0.02, abs=1e-6) and best.turn == pytest.approx(np.sqrt(14e-4), abs=1e-6)
    assert report.arm[0] is best
    assert second.distance == pytest.approx(0.02, abs=1e-6) and second.turn > 1.5


def test_a_key_frame_may_be_far() -> None:
    """40 cm from the present pose, the rotation tells."""
    report = compare_conventions(Conventional("absolute", "absolute quaternion_wxyz", length=0.4))
    assert report.arm_verdict.text.startswith("seems to be absolute_pose, quaternion_wxyz, but ")
    report = compare_conventions(Conventional("absolute", "absolute quaternion_xyzw", length=0.4))
    assert report.arm_verdict.text == "agrees: absolute_pose, quaternion_xyzw."


@pytest.mark.parametrize(
    ("opened", "closed", "says"),
    [
        (1.0, 0.0, "agrees: 1 open, 0 closed."),
        (0.9, 0.2, "agrees: 1 open, 0 closed."),
        (0.0, 1.0, "seems to be 0 open, 1 closed, but the action mode states 1 open, 0 closed: convert"),
        (1.0, -1.0, "seems to be 1 open, -1 closed, but "),
        (-1.0, 1.0, "seems to be -1 open, 1 closed, but "),
        (1.0, 1.0, "undecided: the gripper number (1, 1, 1) does not follow the gripper (open, closed, open)."),
    ],
)
def test_the_gripper_is_recognised(opened: float, closed: float, says: str) -> None:
    """Its number follows the gripper, or the command says so."""
    report = compare_conventions(Conventional("joints", "joint_positions", opened, closed))
    assert report.gripper_verdict.text.startswith(says)
    assert report.differs == says.startswith("seems")


@pytest.mark.parametrize("stated", ["absolute", "delta", "joints"])
@pytest.mark.parametrize("convention", ["zeros", "noise"])
def test_what_cannot_be_told(stated: str, convention: str) -> None:
    """Zeros are near nothing that moves with the pose, and noise is far from everything."""
    report = compare_conventions(Conventional(stated, convention))
    assert report.arm_verdict.text.startswith("undecided: ") and report.gripper_verdict.text.startswith("undecided: ")
    assert not report.differs


@pytest.mark.parametrize(
    ("arm", "fingers", "convention", "numbers", "says"),
    [
        (
            EndEffectorPoseViaPlanning(),
            Discrete(),
            "absolute quaternion_xyzw",
            "arm gripper 0.0",
            "absolute_pose, quaternion_xyzw.",
        ),
        (ERJointViaIK(), Discrete(), "absolute quaternion_xyzw", "arm 0.3 gripper", "absolute_pose, quaternion_xyzw."),
        (
            EndEffectorVelocity(frame="end effector"),
            Discrete(),
            "tip axis_angle",
            "arm gripper",
            "tip velocity, axis_angle, tip frame.",
        ),
        (SafeArm(JointVelocity()), Discrete(), "joint_velocities", "arm gripper", "joint_velocities."),
        (JointPosition(absolute_mode=False), GripperJointPosition(), "joint_deltas", "arm 0.04*gripper", "joint_deltas."),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, ArmActionMode) else "",
)
def test_every_action_mode(arm: ArmActionMode, fingers: GripperActionMode, convention: str, numbers: str, says: str) -> None:
    """Numbers of a pinned joint and of collisions are left out; a finger position is in metres."""
    policy = Conventional("joints", convention)
    policy.action_mode, act = MoveArmThenGripper(arm, fingers), policy.act
    made = {
        "arm": lambda values: values[:-1],
        "gripper": lambda values: values[-1:],
        "0.04*gripper": lambda values: 0.04 * values[-1:],
    }

    def changed(observation: Observation) -> np.ndarray:
        values = act(observation)
        return np.concatenate([made[word](values) if word in made else [float(word)] for word in numbers.split()])

    policy.act = changed  # type: ignore[method-assign]
    report = compare_conventions(policy)
    assert report.arm_verdict.text.startswith(f"agrees: {says}")
    assert report.gripper_verdict.text == f"agrees: {'0.04' if '0.04' in numbers else '1'} open, 0 closed."


def test_a_gripper_number_that_is_a_change() -> None:
    """It cannot be compared with the present state."""
    policy = Conventional("joints", "joint_positions")
    policy.action_mode = MoveArmThenGripper(JointPosition(), GripperJointPosition(absolute_mode=False))
    assert compare_conventions(policy).gripper_verdict.text == "undecided: the gripper number is a change, not a state."


def test_actions_that_are_no_poses() -> None:
    """Torques are refused before the policy is asked."""
    policy = Conventional("joints", "zeros")
    policy.action_mode = MoveArmThenGripper(JointTorque(), Discrete())
    with pytest.raises(TaskEnvironmentError, match="JointTorque, whose actions specify no pose"):
        compare_conventions(policy)
    assert policy.resets == 0


def test_a_wrong_count_of_numbers() -> None:
    """It is a fault of the policy, as in an evaluation."""
    with pytest.raises(PolicyFault, match=r"shape \(10,\); it must be \(8,\)"):
        compare_conventions(Conventional("absolute", "absolute six_rows"))


# Mappings ---------------------------------------------------------------------------------------------------------------------

MAPPING = """
[states]
state = ["tip_position", "tip_quaternion_xyzw", "gripper_open", "joint_positions"]
[action]
"""


def of_server(convention: str, action: str, folder: Path, opened: float = 1.0, closed: float = 0.0) -> ConventionReport:
    """Serve a policy of a convention as openpi does, and compare it with a mapping."""

    def handle(ws: Any) -> None:
        ws.send(encode_openpi({}))
        for frame in ws:
            state = decode_frame(frame)["state"].astype(float)
            arm = arm_numbers(convention, state[:7], state[8:])
            ws.send(encode_openpi({"actions": [[*arm.tolist(), opened if state[7] else closed]]}))

    file = folder / "own.toml"
    file.write_text(MAPPING + action, encoding="utf-8")
    with served(handle) as port:
        return compare_conventions(f"openpi://127.0.0.1:{port}?mapping={file}")


@pytest.mark.parametrize(
    ("stated", "rotation"), [pair for pair in product(ROTATIONS, repeat=2) if ROTATIONS[pair[0]] == ROTATIONS[pair[1]]]
)
def test_a_layout_that_a_mapping_confuses(stated: str, rotation: str, tmp_path: Path) -> None:
    """All layouts of the same count of numbers, of absolute poses."""
    report = of_server(f"absolute {rotation}", f'arm = "absolute_pose"\nrotation = "{stated}"', tmp_path)
    if stated == rotation:
        assert report.arm_verdict.text == f"agrees: absolute_pose, {stated}." and not report.differs
    else:
        source = f"the mapping '{tmp_path / 'own.toml'}'"
        says = f"seems to be absolute_pose, {rotation}, but {source} states absolute_pose, {stated}: "
        assert report.arm_verdict.text == f'{says}set `rotation = "{rotation}"`.' and report.differs


@pytest.mark.parametrize("frame", ["world", "tip"])
def test_the_frame_is_told_where_the_motions_lead_to_one_place(frame: str, tmp_path: Path) -> None:
    """The length of a delta is the same in both; of small turns, axis-angle and roll, pitch, yaw are the same, too."""
    report = of_server(f"{frame} axis_angle", 'arm = "delta_pose"\nframe = "world"', tmp_path)
    if frame == "world":
        assert (
            report.arm_verdict.text == "agrees: delta_pose, axis_angle, world frame. Not distinguished from: rotation euler_rpy."
        )
    else:
        assert 'states delta_pose, axis_angle, world frame: set `frame = "tip"`.' in report.arm_verdict.text
    assert report.differs == (frame == "tip")


def test_scales_are_those_of_the_mapping(tmp_path: Path) -> None:
    """An absolute pose is in metres, whatever the factor of the deltas that the mapping states."""
    action = 'arm = "delta_pose"\nclip = 1.0\nscale = 0.05\nrotation_scale = 0.5\ngripper_open = -1.0\ngripper_closed = 1.0'
    report = of_server("absolute axis_angle", action, tmp_path)
    assert 'set `arm = "absolute_pose"`.' in report.arm_verdict.text
    assert report.gripper_verdict.text.endswith("set `gripper_open = 1`, `gripper_closed = 0`.")
    report = of_server("world axis_angle", action, tmp_path, opened=-1.0, closed=1.0)
    best = report.arm[0]
    assert not report.differs and best.distance == pytest.approx(0.05 * 0.02, abs=1e-4)


# The command ------------------------------------------------------------------------------------------------------------------


def test_the_command_prints_a_table_and_verdicts(capsys: pytest.CaptureFixture[str]) -> None:
    """0 where the conventions agree, 1 where one seems to differ; the stated ones are marked."""
    assert exit_code("conventions", f"{FILE}:Conventional?stated=absolute&convention=absolute quaternion_wxyz") == 1
    lines = capsys.readouterr().out.splitlines()
    assert "absolute_pose, quaternion_wxyz" in lines[1] and " 20 mm " in lines[1]
    assert [line.split()[0] for line in lines if line.endswith("<- the action mode")] == ["arm", "gripper"]
    assert lines[-2].startswith("arm: seems to be absolute_pose, quaternion_wxyz") and lines[-1].startswith("gripper: agrees")
    assert exit_code("conventions", "noop", "--task", "push_button") == 0
    assert "arm: agrees: joint_positions." in capsys.readouterr().out


def test_the_command_with_another_arm(capsys: pytest.CaptureFixture[str]) -> None:
    """All poses are reached; six joints are six numbers."""
    assert exit_code("conventions", "noop", "--robot", "ur5e") == 0
    out = capsys.readouterr().out
    assert "arm: agrees: joint_positions." in out and "delta_pose, axis_angle" in out
