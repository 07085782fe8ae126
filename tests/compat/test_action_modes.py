"""Action modes: what each does, the dialects of programs, and modes that programs write themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pyrep.const import ObjectType
from pyrep.errors import ConfigurationPathError, IKError
from rlbench.action_modes import arm_action_modes as arms
from rlbench.action_modes.action_mode import ActionMode, JointPositionActionMode, MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import (
    Algos,
    ArmActionMode,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    ERJointViaIK,
    JointPosition,
    JointTorque,
    JointVelocity,
    RelativeFrame,
    assert_action_shape,
    assert_unit_quaternion,
    calculate_delta_pose,
)
from rlbench.action_modes.gripper_action_modes import (
    Discrete,
    GripperActionMode,
    GripperJointPosition,
)
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.scene import Scene
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import OpenDrawer, PickAndLift, ReachTarget, TakeLidOffSaucepan


def launched() -> Iterator[Environment]:
    """Yield a launched environment without images, and shut it down."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    environment = Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True)
    environment.launch()
    yield environment
    environment.shutdown()


def fresh_scene(environment: Environment) -> Scene:
    """Return the scene of a fresh episode."""
    np.random.seed(1)
    task = environment.get_task(ReachTarget)
    task.reset()
    scene: Scene = task._scene
    return scene


DOWN = [0.0, 1.0, 0.0, 0.0]
HALF = [0.0, 0.0, np.sin(0.1), np.cos(0.1)]


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without images."""
    yield from launched()


@pytest.fixture
def scene(environment: Environment) -> Any:
    """The scene of a fresh episode."""
    return fresh_scene(environment)


def test_modes_are_of_the_known_classes() -> None:
    """Programs ask with isinstance."""
    for mode in (JointVelocity(), JointPosition(), JointTorque(), EndEffectorPoseViaPlanning(), EndEffectorPoseViaIK()):
        assert isinstance(mode, ArmActionMode)
    assert isinstance(ERJointViaIK(), ArmActionMode)
    assert isinstance(Discrete(), GripperActionMode) and isinstance(GripperJointPosition(), GripperActionMode)
    assert isinstance(JointPositionActionMode(), ActionMode)


def test_names_that_programs_import_through_the_module() -> None:
    """The module shows what it works with."""
    for name in ("Scene", "Robot", "InvalidActionError", "SUPPORTED_ROBOTS", "ObjectType", "Algos", "ConfigurationPathError"):
        assert hasattr(arms, name)
    assert arms.InvalidActionError is InvalidActionError
    assert (RelativeFrame.WORLD.value, RelativeFrame.EE.value) == (0, 1)


def test_shapes_and_bounds(scene: Any) -> None:
    """Arm shapes are tuples, the whole is a number; bounds fit the shape."""
    shapes = {JointVelocity: 7, JointPosition: 7, JointTorque: 7, EndEffectorPoseViaPlanning: 7, EndEffectorPoseViaIK: 7}
    for kind, size in {**shapes, ERJointViaIK: 8}.items():
        assert kind().action_shape(scene) == (size,)
        mode = MoveArmThenGripper(kind(), Discrete())
        assert mode.action_shape(scene) == size + 1
        low, high = mode.action_bounds()
        assert low.shape == high.shape == (size + 1,) and np.all(low < high)
    assert EndEffectorPoseViaPlanning().action_shape(None) == (7,) and Discrete().action_shape(None) == (1,)
    low, high = JointPositionActionMode().action_bounds()
    np.testing.assert_allclose(low, [-0.1] * 7 + [0.0])
    np.testing.assert_allclose(high, [0.1] * 7 + [0.04])


def test_joint_velocity_moves_one_step_and_stops(scene: Any) -> None:
    """A tenth of a radian per second for a twentieth of a second."""
    before, ticks = np.array(scene.robot.arm.get_joint_positions()), scene.runtime.world.ticks
    MoveArmThenGripper(JointVelocity(), Discrete()).action(scene, [0.1] * 7 + [1.0])
    assert scene.runtime.world.ticks == ticks + 1
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions() - before, 0.005, atol=1e-3)
    assert scene.robot.arm.get_joint_target_velocities() == [0.0] * 7


@pytest.mark.parametrize("absolute", [True, False])
def test_joint_position(scene: Any, absolute: bool) -> None:
    """Absolute or relative, one step towards the target."""
    before = np.array(scene.robot.arm.get_joint_positions())
    JointPosition(absolute_mode=absolute).action(scene, before + 0.02 if absolute else np.full(7, 0.02))
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions(), before + 0.02, atol=3e-3)


def test_joint_torque_turns_a_joint(scene: Any) -> None:
    """Gravity and a little more turns the first joint the positive way."""
    q = np.array(scene.robot.arm.get_joint_positions())
    mode = JointTorque()
    mode.set_control_mode(scene.robot)
    mode.action(scene, scene.runtime.model.gravity(q) + [3.0, 0, 0, 0, 0, 0, 0])
    assert scene.robot.arm.get_joint_velocities()[0] > 0.02


def test_planning_goes_to_the_pose(scene: Any) -> None:
    """Within a millimetre; a relative action composes with the tip's pose as the known rules say."""
    mode = EndEffectorPoseViaPlanning()
    mode.action(scene, [0.3, 0.1, 1.2, *DOWN])
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), [0.3, 0.1, 1.2], atol=1e-3)
    turned = Rotation.from_quat(HALF) * Rotation.from_quat(scene.robot.arm.get_tip().get_quaternion())
    EndEffectorPoseViaPlanning(absolute_mode=False).action(scene, [0.0, 0.05, 0.02, *HALF])
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), [0.3, 0.15, 1.22], atol=2e-3)
    now = Rotation.from_quat(scene.robot.arm.get_tip().get_quaternion())
    assert (now * turned.inv()).magnitude() < 0.01


@pytest.mark.parametrize("frame", [RelativeFrame.EE, "end effector"])
@pytest.mark.parametrize("kind", [EndEffectorPoseViaPlanning, EndEffectorPoseViaIK])
def test_the_frame_of_the_end_effector(scene: Any, kind: type, frame: Any) -> None:
    """Two centimetres along the tip's own z axis, whatever the enumeration or word says it by."""
    matrix = scene.robot.arm.get_tip().get_matrix()
    kind(frame=frame).action(scene, [0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), matrix[:3, 3] + 0.02 * matrix[:3, 2], atol=3e-3)


def test_inverse_kinematics_with_a_pinned_joint(scene: Any) -> None:
    """The first joint reaches its target, the tip does not move."""
    tip = scene.robot.arm.get_tip().get_pose()
    ERJointViaIK(commanded_joints=[0]).action(scene, [*tip, 0.15])
    assert scene.robot.arm.get_joint_positions()[0] == pytest.approx(0.15, abs=0.01)
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), tip[:3], atol=5e-3)


def test_the_hand_opens_and_closes(scene: Any) -> None:
    """Below one half it closes; the same again does nothing."""
    hand = Discrete()
    hand.action(scene, [0.0])
    assert max(scene.robot.gripper.get_open_amount()) < 0.05
    ticks = scene.runtime.world.ticks
    hand.action(scene, np.array([0.0]))
    assert scene.runtime.world.ticks == ticks
    GripperJointPosition().action(scene, [0.008])
    assert scene.robot.gripper.get_joint_positions()[0] == pytest.approx(0.008, abs=2e-3)


def test_any_finite_number_is_meant_for_the_hand(scene: Any) -> None:
    """Networks give values beyond 0 and 1: above one half is open; NaN is refused."""
    hand = Discrete()
    for value, opening in ((-0.3, 0.0), (7.0, 1.0), (0.5, 0.0), (0.51, 1.0)):
        hand.action(scene, [value])
        np.testing.assert_allclose(scene.robot.gripper.get_open_amount(), opening, atol=0.05)
    with pytest.raises(InvalidActionError, match="NaN"):
        hand.action(scene, [float("nan")])


def test_settings_by_their_known_names_can_be_changed(scene: Any) -> None:
    """Programs switch collision checks and relative poses of a mode that exists."""
    mode, hand = EndEffectorPoseViaPlanning(), Discrete()
    mode._collision_checking, mode._absolute_mode, mode._frame = True, False, "end effector"
    hand._attach_grasped_objects, hand._detach_before_open = False, False
    assert mode.collision_checking and not mode.absolute_mode and mode.frame == RelativeFrame.EE == mode._frame
    assert hand.attach_grasped_objects is False and not hand.detach_before_open
    joints = JointPosition()
    joints._absolute_mode = False
    assert not joints.absolute_mode


def test_joint_position_action_mode_takes_one_step(scene: Any) -> None:
    """Arm and fingers move within the same step."""
    before, ticks = np.array(scene.robot.arm.get_joint_positions()), scene.runtime.world.ticks
    JointPositionActionMode().action(scene, [0.02] * 7 + [0.032])
    assert scene.runtime.world.ticks == ticks + 1
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions() - before, 0.02, atol=4e-3)
    assert scene.robot.gripper.get_joint_positions()[0] < 0.037


REFUSED = [
    ("shape", JointVelocity, [0.1] * 6 + [1.0]),
    ("NaN", JointVelocity, [float("nan")] * 7 + [1.0]),
    ("NaN", JointVelocity, [0.1] * 7 + [float("inf")]),
    ("norm", EndEffectorPoseViaPlanning, [0.3, 0.1, 1.2, 0.0, 2.0, 0.0, 0.0, 1.0]),
    ("outside the workspace", EndEffectorPoseViaPlanning, [0.3, 0.1, 9.0, *DOWN, 1.0]),
    ("No motion", EndEffectorPoseViaPlanning, [0.77, 0.65, 1.74, *DOWN, 0.0]),
    ("No joint positions", EndEffectorPoseViaIK, [0.3, 0.1, 9.0, *DOWN, 0.0]),
]


@pytest.mark.parametrize(("words", "kind", "action"), REFUSED)
def test_a_refused_action_changes_nothing(scene: Any, words: str, kind: type, action: list[float]) -> None:
    """The error says why, and no time passes."""
    before, ticks = scene.robot.arm.get_joint_positions(), scene.runtime.world.ticks
    with pytest.raises(InvalidActionError, match=words):
        MoveArmThenGripper(kind(), Discrete()).action(scene, np.array(action))
    assert scene.runtime.world.ticks == ticks
    assert scene.robot.arm.get_joint_positions() == before


def test_a_ninth_value_says_whether_collisions_are_ignored(scene: Any) -> None:
    """For the mode that plans; others refuse the number."""
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(collision_checking=True), Discrete())
    for flag in (0.0, 1.0):
        mode.action(scene, np.array([0.3, 0.1 * flag, 1.2, *DOWN, 1.0, flag]))
        np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), [0.3, 0.1 * flag, 1.2], atol=1e-3)
    with pytest.raises(InvalidActionError, match="shape"):
        MoveArmThenGripper(JointVelocity(), Discrete()).action(scene, [0.0] * 9)


def test_checks_are_given_up_only_when_the_action_asked_for_them(scene: Any) -> None:
    """Into the table: refused by the mode's own setting, gone to when the ninth value asks for checks, as its dialect does."""
    low = [0.3, 0.1, 0.754, *DOWN]
    with pytest.raises(InvalidActionError, match="table"):
        EndEffectorPoseViaPlanning(collision_checking=True).action(scene, low)
    EndEffectorPoseViaPlanning().action(scene, low, ignore_collisions=False)
    assert scene.robot.arm.get_tip().get_position()[2] < 0.77


def test_helpers_that_programs_call(scene: Any) -> None:
    """Shape, quaternion, and the delta pose along world axes."""
    assert_action_shape(np.zeros(7), (7,))
    assert_action_shape([0.0], (1,))
    with pytest.raises(InvalidActionError, match=r"has to be \(7,\)"):
        assert_action_shape(np.zeros(8), (7,))
    assert_unit_quaternion([0, 0, 0, 1])
    with pytest.raises(InvalidActionError, match="norm"):
        assert_unit_quaternion([0, 0, 0, 2])
    tip = scene.robot.arm.get_tip().get_pose()
    moved = calculate_delta_pose(scene.robot, [0.1, 0.0, -0.2, *HALF])
    np.testing.assert_allclose(moved[:3], tip[:3] + [0.1, 0.0, -0.2])
    expected = Rotation.from_quat(HALF) * Rotation.from_quat(tip[3:])
    assert (Rotation.from_quat(moved[3:]) * expected.inv()).magnitude() < 1e-6


def test_observations_of_a_motion(scene: Any) -> None:
    """A function gets one per step, and as many as asked for after the end."""
    mode, seen = EndEffectorPoseViaPlanning(), []
    mode.set_callable_each_step(seen.append)
    mode.action(scene, [0.3, 0.1, 1.2, *DOWN])
    count = len(seen)
    assert count > 10 and np.abs(seen[-1].gripper_pose[:3] - [0.3, 0.1, 1.2]).max() < 2e-3
    mode.record_end(scene, steps=5)
    assert len(seen) == count + 5
    mode.record_end(scene, steps=2, step_scene=False)
    assert len(seen) == count + 7


def test_control_modes(scene: Any) -> None:
    """Velocity modes switch position control off, the others on."""
    JointVelocity().set_control_mode(scene.robot)
    assert scene.runtime.robot.mode == "velocity"
    EndEffectorPoseViaPlanning().set_control_mode(scene.robot)
    assert scene.runtime.robot.mode == "position"


class DialectPlanning(EndEffectorPoseViaPlanning):
    """A planning mode in the shape of the older dialect: frames by words, shapes switched off while it plans."""

    def action(self, scene: Scene, action: np.ndarray, ignore_collisions: bool = True) -> None:  # type: ignore[override]
        """Plan around everything but what the arm touches."""
        if not self._absolute_mode and self._frame != "end effector":
            action = calculate_delta_pose(scene.robot, action)
        relative_to = None if self._frame == "world" else scene.robot.arm.get_tip()
        self._quick_boundary_check(scene, action)
        if self._robot_shapes is None:
            self._robot_shapes = scene.robot.arm.get_objects_in_tree(object_type=ObjectType.SHAPE)
        touched = [
            shape
            for shape in scene.pyrep.get_objects_in_tree(object_type=ObjectType.SHAPE)
            if shape.is_collidable() and shape not in self._robot_shapes and scene.robot.arm.check_arm_collision(shape)
        ]
        for shape in touched:
            shape.set_collidable(False)
        path = scene.robot.arm.get_path(
            action[:3], quaternion=action[3:], ignore_collisions=not self._collision_checking, relative_to=relative_to
        )
        for shape in touched:
            shape.set_collidable(True)
        done = False
        while not done:
            done = path.step()
            scene.step()


@pytest.mark.parametrize(
    ("arguments", "action"),
    [
        ((True, "world", True), [0.3, 0.1, 1.2, *DOWN]),
        ((False, "world", True), [0.0, 0.05, -0.1, 0.0, 0.0, 0.0, 1.0]),
        ((True, "end effector", True), [0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0]),
        ((), [0.3, 0.1, 1.2, *DOWN]),
    ],
)
def test_a_mode_in_the_older_dialect(scene: Any, arguments: tuple[Any, ...], action: list[float]) -> None:
    """Whatever frame it is given, by word or by default, it goes where the known rules say."""
    tip = scene.robot.arm.get_tip()
    matrix, position = tip.get_matrix(), tip.get_position()
    goals = {
        (False, "world", True): position + action[:3],
        (True, "end effector", True): position + 0.05 * matrix[:3, 2],
    }
    MoveArmThenGripper(DialectPlanning(*arguments), Discrete()).action(scene, np.array([*action, 1.0]))
    np.testing.assert_allclose(tip.get_position(), goals.get(arguments, action[:3]), atol=1e-3)


def test_frames_equal_their_words() -> None:
    """And nothing else."""
    assert RelativeFrame.WORLD == "world" and RelativeFrame.EE != "world" and RelativeFrame.EE == 1
    assert {RelativeFrame.EE: 3}[RelativeFrame(1)] == 3


def play(scene: Scene) -> bool:
    """Follow the waypoints of a task, and operate the hand as they say; return whether the goal was reached."""
    gripper = scene.robot.gripper
    for point in scene.task.get_waypoints():
        point.start_of_path()
        path = point.get_path()
        done = False
        while not done:
            done = path.step()
            scene.step()
        point.end_of_path()
        words = point.get_ext()
        if "gripper(" not in words:
            continue
        opens = "open_gripper(" in words
        if opens:
            gripper.release()
        done = False
        while not done:
            done = gripper.actuate(1.0 if opens else 0.0, velocity=0.04)
            scene.pyrep.step()
            scene.task.step()
        if not opens:
            for graspable in scene.task.get_graspable_objects():
                gripper.grasp(graspable)
    return bool(scene.task.success()[0])


@pytest.mark.simulation
@pytest.mark.parametrize("task", [ReachTarget, TakeLidOffSaucepan, PickAndLift, OpenDrawer])
def test_a_program_plays_a_demonstration_by_itself(environment: Environment, task: type) -> None:
    """Paths, fingers and grasps suffice to reach the goals of tasks."""
    np.random.seed(4)
    loaded = environment.get_task(task)
    loaded.reset()
    assert play(loaded._scene)


class CarefulPlanning(EndEffectorPoseViaPlanning):
    """A planning mode that follows paths by itself, and plans again without checks."""

    def action(self, scene: Scene, action: np.ndarray, ignore_collisions: bool = True) -> None:  # type: ignore[override]
        """Plan, then step path and scene in turn."""
        assert_action_shape(action, (7,))
        assert_unit_quaternion(action[3:])
        self._quick_boundary_check(scene, action)
        self.flags = [*getattr(self, "flags", []), ignore_collisions]
        try:
            path = scene.robot.arm.get_path(
                action[:3],
                quaternion=action[3:],
                ignore_collisions=ignore_collisions,
                trials=100,
                max_configs=10,
                max_time_ms=10,
                trials_per_goal=5,
                algorithm=Algos.RRTConnect,
            )
        except ConfigurationPathError as error:
            raise InvalidActionError("No path.") from error
        done = False
        while not done:
            done = path.step()
            scene.step()
            success, _ = scene.task.success()
            if success:
                break


class NineValues(MoveArmThenGripper):
    """A mode that splits nine values by itself."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Give the last value to the arm."""
        size = int(np.prod(self.arm_action_mode.action_shape(scene)))
        arm, hand, ignore = np.array(action[:size]), np.array(action[size : size + 1]), bool(action[-1])
        self.arm_action_mode.action(scene, arm, ignore)  # type: ignore[call-arg]
        self.gripper_action_mode.action(scene, hand)


def test_a_planning_mode_of_ones_own(scene: Any) -> None:
    """It reaches its goal by stepping path and scene, and refuses what has no path."""
    mode = MoveArmThenGripper(CarefulPlanning(), Discrete())
    mode.action(scene, np.array([0.3, 0.1, 1.2, *DOWN, 0.0]))
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), [0.3, 0.1, 1.2], atol=1e-3)
    assert max(scene.robot.gripper.get_open_amount()) < 0.05
    with pytest.raises(InvalidActionError, match="No path"):
        mode.action(scene, np.array([0.77, 0.65, 1.74, *DOWN, 0.0]))
    with pytest.raises(InvalidActionError, match="workspace"):
        mode.action(scene, np.array([0.3, 0.1, 9.0, *DOWN, 0.0]))


@pytest.mark.parametrize("whole", [NineValues, MoveArmThenGripper])
def test_nine_values_reach_the_users_arm_mode(scene: Any, whole: type[MoveArmThenGripper]) -> None:
    """Whether the user splits them or the built-in mode does."""
    arm = CarefulPlanning()
    for flag in (1.0, 0.0):
        whole(arm, Discrete()).action(scene, np.array([0.3, 0.1, 1.2 + 0.1 * flag, *DOWN, 1.0, flag]))
    assert arm.flags == [True, False]


class Hooked(JointPosition):
    """Counts its own hooks."""

    calls: tuple[str, ...] = ()

    def action_pre_step(self, scene: Any, action: Any) -> None:
        """Note, then do as built in."""
        self.calls += ("pre",)
        super().action_pre_step(scene, action)

    def action_post_step(self, scene: Any, action: Any) -> None:
        """Note, then do as built in."""
        self.calls += ("post",)
        super().action_post_step(scene, action)


def test_hooks_of_a_derived_mode_are_called(scene: Any) -> None:
    """Before and after the step."""
    mode = Hooked()
    before = np.array(scene.robot.arm.get_joint_positions())
    MoveArmThenGripper(mode, Discrete()).action(scene, [*(before + 0.01), 1.0])
    assert mode.calls == ("pre", "post")
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions(), before + 0.01, atol=2e-3)


class BothAtOnce(ActionMode):
    """Arm and hand within the same steps, by the three hooks of both parts."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Command both, step, end both."""
        arm, hand = np.array(action[:7]), np.array(action[7:])
        self.arm_action_mode.action_pre_step(scene, arm)
        self.gripper_action_mode.action_pre_step(scene, hand)
        scene.step()
        self.arm_action_mode.action_post_step(scene, arm)
        self.gripper_action_mode.action_post_step(scene, hand)

    def action_shape(self, scene: Scene) -> int:  # type: ignore[override]
        """Seven joints and the hand."""
        return 8


@pytest.mark.parametrize(("hand", "closed"), [(GripperJointPosition(), 0.0), (Discrete(), 0.0)])
def test_a_whole_mode_of_ones_own(scene: Any, hand: Any, closed: float) -> None:
    """Arm and fingers move in the same steps."""
    mode, ticks = BothAtOnce(JointVelocity(), hand), scene.runtime.world.ticks
    before = np.array(scene.robot.arm.get_joint_positions())
    for _ in range(6):
        mode.action(scene, np.array([0.1] * 7 + [closed]))
    assert scene.runtime.world.ticks == ticks + 6
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions() - before, 0.03, atol=5e-3)
    assert max(scene.robot.gripper.get_open_amount()) < 0.1
    with pytest.raises(NotImplementedError, match="action_bounds"):
        mode.action_bounds()


class JointsByConstructor(JointPositionActionMode):
    """Replaces the parts, past the constructor of its base."""

    def __init__(self) -> None:
        super(JointPositionActionMode, self).__init__(JointPosition(True), GripperJointPosition(True))


def test_parts_of_the_joint_position_mode_can_be_replaced(scene: Any) -> None:
    """Absolute joint positions in place of differences."""
    q = np.array(scene.robot.arm.get_joint_positions()) + 0.02
    JointsByConstructor().action(scene, [*q, 0.04])
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions(), q, atol=3e-3)


class DeltaByJacobian(ArmActionMode):
    """A Cartesian delta, by inverse kinematics of the arm and joint targets."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Solve, and step until the joints are there."""
        pose = calculate_delta_pose(scene.robot, action)
        try:
            joints = scene.robot.arm.solve_ik_via_jacobian(pose[:3], quaternion=pose[3:])
        except IKError as error:
            raise InvalidActionError("Cannot be reached.") from error
        scene.robot.arm.set_joint_target_positions(joints)
        for _ in range(50):
            scene.step()
            if np.allclose(scene.robot.arm.get_joint_positions(), joints, atol=2e-3):
                return

    def action_shape(self, scene: Scene) -> tuple[int]:  # type: ignore[override]
        """A pose."""
        return (7,)


class Squeeze(GripperActionMode):
    """Closes by `actuate`, and grasps what the task lets it."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Actuate until done."""
        done = False
        while not done:
            done = scene.robot.gripper.actuate(float(action[0]), velocity=0.2)
            scene.step()
        for graspable in scene.task.get_graspable_objects():
            scene.robot.gripper.grasp(graspable)

    def action_shape(self, scene: Scene) -> tuple[int]:  # type: ignore[override]
        """One number."""
        return (1,)


def test_parts_of_ones_own_in_the_built_in_mode(scene: Any) -> None:
    """They see the scene, and their shapes add up."""
    mode = MoveArmThenGripper(DeltaByJacobian(), Squeeze())
    assert mode.action_shape(scene) == 8
    start = scene.robot.arm.get_tip().get_position()
    mode.action(scene, [0.0, 0.04, -0.05, 0, 0, 0, 1, 0.3])
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), start + [0.0, 0.04, -0.05], atol=3e-3)
    assert scene.robot.gripper.get_open_amount() == pytest.approx([0.3, 0.3], abs=0.03)
    with pytest.raises(InvalidActionError, match="Cannot be reached"):
        mode.action(scene, [5.0, 0.0, 0.0, 0, 0, 0, 1, 0.3])


class VelocityByCommand(JointVelocity):
    """Commands the arm itself, as the built-in mode of others does."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Go for three steps, then stop."""
        scene.robot.arm.set_joint_target_velocities(action)
        for _ in range(3):
            scene.step()
        scene.robot.arm.set_joint_target_velocities(np.zeros_like(action))


def test_a_velocity_mode_of_ones_own(scene: Any) -> None:
    """Three steps at 0.2 rad/s, whatever the arm did before."""
    before = np.array(scene.robot.arm.get_joint_positions())
    MoveArmThenGripper(VelocityByCommand(), Discrete()).action(scene, np.array([0.2] * 7 + [1.0]))
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions() - before, 0.03, atol=5e-3)
