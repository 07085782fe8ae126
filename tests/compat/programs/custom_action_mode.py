"""Someone with a controller of their own: parts of an action mode written anew, and one that moves arm and hand at once."""

import numpy as np
from scipy.spatial.transform import Rotation

from rlbench.action_modes.action_mode import ActionMode, MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import ArmActionMode, EndEffectorPoseViaIK, JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete, GripperActionMode, GripperJointPosition
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.scene import Scene
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import PickAndLift, ReachTarget


class SmoothJointDelta(ArmActionMode):
    """Spreads a joint displacement over several steps."""

    def __init__(self, steps: int = 5):
        self.steps = steps
        self.calls = 0

    def action(self, scene: Scene, action: np.ndarray):
        if len(action) != self.action_shape(scene)[0]:
            raise InvalidActionError("expected %s numbers" % self.action_shape(scene))
        arm = scene.robot.arm
        start = np.array(arm.get_joint_positions())
        for step in range(1, self.steps + 1):
            arm.set_joint_target_positions(list(start + np.asarray(action) * step / self.steps))
            scene.step()
        self.calls += 1

    def action_shape(self, scene: Scene) -> tuple:
        return (scene.robot.arm.get_joint_count(),)


class TipVelocity(ArmActionMode):
    """Velocity of the tip, through the arm's Jacobian."""

    def action(self, scene, action):
        arm = scene.robot.arm
        jacobian = np.asarray(arm.get_jacobian())
        jacobian = jacobian.T if jacobian.shape[0] == 7 else jacobian
        joint_velocities = np.linalg.pinv(jacobian[:3]) @ action
        arm.set_joint_target_positions(list(np.array(arm.get_joint_positions()) + 0.05 * joint_velocities))
        scene.step()

    def action_shape(self, scene):
        return (3,)


class SlowHand(GripperActionMode):
    """Opens or shuts slowly, and holds what is between the fingers."""

    def action(self, scene: Scene, action: np.ndarray):
        gripper, amount = scene.robot.gripper, float(action[0] > 0.5)
        if amount == 1.0:
            gripper.release()
        done = False
        while not done:
            done = gripper.actuate(amount, velocity=0.04)
            scene.step()
        if amount == 0.0:
            for item in scene.task.get_graspable_objects():
                gripper.grasp(item)

    def action_shape(self, scene: Scene) -> tuple:
        return (1,)


class Together(ActionMode):
    """Arm target and finger target in one simulation step."""

    def __init__(self):
        super().__init__(JointVelocity(), GripperJointPosition())

    def action(self, scene: Scene, action: np.ndarray):
        scene.robot.arm.set_joint_target_velocities(list(action[:7]))
        scene.robot.gripper.set_joint_target_positions([action[7]] * 2)
        scene.step()

    def action_shape(self, scene: Scene):
        return 8

    def action_bounds(self):
        return np.array([-1.0] * 7 + [0.0]), np.array([1.0] * 7 + [0.04])


class EulerDelta(MoveArmThenGripper):
    """Seven numbers instead of eight: the rotation of the tip as three angles."""

    def __init__(self):
        super().__init__(EndEffectorPoseViaIK(absolute_mode=False), Discrete())

    def action(self, scene, action):
        rotation = Rotation.from_euler("xyz", action[3:6]).as_quat()
        super().action(scene, np.concatenate([action[:3], rotation, action[6:]]))

    def action_shape(self, scene):
        return 7


def low_dim():
    obs_config = ObservationConfig(gripper_joint_positions=True)
    obs_config.set_all_high_dim(False)
    return obs_config


def with_own_parts():
    arm_mode = SmoothJointDelta()
    env = Environment(MoveArmThenGripper(arm_mode, SlowHand()), obs_config=low_dim(), headless=True)
    env.launch()
    assert env.action_shape == (8,)
    task = env.get_task(PickAndLift)
    _, obs = task.reset()
    delta = np.array([0.1, 0.0, 0.0, -0.1, 0.0, 0.1, 0.0])
    after, _, _ = task.step(np.append(delta, 0.0))
    moved = after.joint_positions - obs.joint_positions
    assert np.abs(moved - delta).max() < 0.03, moved
    assert arm_mode.calls == 1 and after.gripper_open == 0.0 and after.gripper_joint_positions.max() < 0.005
    again, _, _ = task.step(np.append(np.zeros(7), 1.0))
    assert again.gripper_open == 1.0 and again.gripper_joint_positions.min() > 0.036
    try:
        task.step(np.zeros(3))
    except (InvalidActionError, RuntimeError, ValueError) as error:
        print("too short an action:", error)
    else:
        raise AssertionError("three numbers were taken")
    env.shutdown()
    return moved


def with_tip_velocity():
    env = Environment(MoveArmThenGripper(TipVelocity(), Discrete()), obs_config=low_dim(), headless=True)
    env.launch()
    task = env.get_task(ReachTarget)
    _, obs = task.reset()
    start = obs.gripper_pose[:3]
    for _ in range(10):
        obs, _, _ = task.step(np.array([0.1, 0.05, 0.0, 1.0]))
    env.shutdown()
    return obs.gripper_pose[:3] - start


def with_a_whole_mode():
    mode = Together()
    env = Environment(mode, obs_config=low_dim(), headless=True)
    env.launch()
    task = env.get_task(ReachTarget)
    _, obs = task.reset()
    start = obs.joint_positions
    low, high = mode.action_bounds()
    for _ in range(5):
        obs, _, _ = task.step(np.array([0.2] + [0.0] * 6 + [0.01]))
    assert env.action_shape == (8,) and len(low) == len(high) == 8
    assert 0.02 < obs.joint_positions[0] - start[0] < 0.07, obs.joint_positions[0] - start[0]
    assert obs.gripper_joint_positions.max() < 0.03, obs.gripper_joint_positions
    env.shutdown()


def with_angles():
    env = Environment(EulerDelta(), obs_config=low_dim(), headless=True)
    env.launch()
    assert env.action_shape == (7,)
    task = env.get_task(ReachTarget)
    _, obs = task.reset()
    start = Rotation.from_quat(obs.gripper_pose[3:])
    obs, _, _ = task.step(np.array([-0.02, 0.0, -0.02, 0.0, 0.0, 0.2, 1.0]))
    turned = (Rotation.from_quat(obs.gripper_pose[3:]) * start.inv()).as_rotvec()
    env.shutdown()
    assert np.allclose(turned, [0.0, 0.0, 0.2], atol=0.02), turned


def main():
    np.random.seed(9)
    moved = with_own_parts()
    travelled = with_tip_velocity()
    assert np.allclose(travelled, [0.05, 0.025, 0.0], atol=0.02), travelled
    with_a_whole_mode()
    with_angles()
    print("joints by", moved.round(2), "tip by", travelled.round(3))


if __name__ == "__main__":
    main()
