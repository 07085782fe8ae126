"""Pick and lift by a planner and a follower: `python 07_plan_and_follow.py --seeds 0 20`.

Neither depends on the simulator: the planner gets a snapshot of the world and returns a timed trajectory, and the follower
computes a joint velocity from the trajectory and the measured joints 20 times per second.

What to look for: the whole grasp is planned before the arm moves, so that a gripper yaw without a plan costs no motion;
the held block is part of the arm in the next plan; the joints stay within a fraction of a degree of their trajectory.
"""

from __future__ import annotations

import argparse

import numpy as np

from rlbench_pin import Discrete, Environment, JointVelocity, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.control import TrajectoryFollower, VelocityFollowing
from rlbench_pin.environment import low_dim_config
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning import MotionPlanner, Plan, symmetric_poses
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.spatial import FloatArray, compose, pose_at

OPEN, CLOSED = 1.0, 0.0
ABOVE = [0.0, 0.0, 0.1]  # from here the gripper goes straight down to the block [m]
DOWN = pose_at([0.0, 0.0, 0.0], roll=np.pi)  # a gripper that points down
SETTLE = 20  # control ticks that the arm may take to come to rest


class Picker:
    """Plans, follows and grasps; it acts on the world only through `task.step`."""

    def __init__(self, task: TaskEnvironment, seed: int) -> None:
        self.task, self.rng = task, np.random.default_rng(seed)
        self.model = RobotModel(robot_description("panda"))
        self.planner = MotionPlanner(self.model)
        self.gripper, self.success, self.error = OPEN, False, 0.0
        _, self.obs = task.reset(seed=seed)

    def pick_and_lift(self) -> bool:
        """Grasp the block from above and move it to the marker; return whether the task is solved."""
        world = self.task.world
        for plan in self.plan_grasp(world.body("block").pose):
            self.follow(plan)
        self.grip(CLOSED)
        lifted = compose(pose_at(ABOVE), self.obs.gripper_pose)  # compose(T_world_there, T_there_tip)
        self.follow(self.plan(lifted, straight=True))
        marker = compose(pose_at(world.body("marker").position), DOWN)
        self.follow(self.plan(symmetric_poses(marker, 4)))
        return self.success

    def plan_grasp(self, block: FloatArray) -> tuple[Plan, Plan]:
        """Plan above the block and down to it, with the first gripper yaw for which both are possible.

        Args:
            block: Pose of the block (7,); a cube has four equivalent yaws.
        """
        self.planner.update(self.task.world.snapshot())
        refused = []
        for grasp in symmetric_poses(compose(block, DOWN), 4):
            above = compose(pose_at(ABOVE), grasp)
            try:
                way = self.planner.plan_to_pose(self.obs.joint_positions, above, rng=self.rng)
                return way, self.planner.plan_to_pose(way.path[-1], grasp, straight=True, allowed=["block"], rng=self.rng)
            except PlanningError as error:  # it says what is in the way, or out of reach
                refused.append(error)
        raise refused[0]

    def plan(self, pose: FloatArray | list[FloatArray], straight: bool | None = None) -> Plan:
        """Plan from the present configuration; a grasped body is part of the arm."""
        self.planner.update(self.task.world.snapshot())
        return self.planner.plan_to_pose(self.obs.joint_positions, pose, straight=straight, rng=self.rng)

    def follow(self, plan: Plan) -> None:
        """Follow a trajectory by joint velocities until the arm is at rest at its end, or the task is solved."""
        follower = TrajectoryFollower(plan.trajectory, VelocityFollowing(self.model.limits))
        rest = SETTLE
        while not self.success and rest > 0:
            velocity = follower.command(self.obs.joint_positions, self.obs.joint_velocities)
            self.step(velocity)
            rest -= follower.done
        self.error = max(self.error, follower.report.largest)

    def grip(self, gripper: float) -> None:
        """Open or close the gripper; the step ends when the fingers are stationary."""
        self.gripper = gripper
        self.step(np.zeros(self.model.size))

    def step(self, velocity: FloatArray) -> None:
        """Hold joint velocities for one control tick."""
        self.obs, reward, _ = self.task.step(np.append(velocity, self.gripper))
        self.success = self.success or reward == 1.0


def main() -> None:
    """Play the seeds of the command line, one episode each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs=2, type=int, default=[0, 3], metavar=("FIRST", "END"), help="seeds FIRST to END - 1")
    seeds = range(*parser.parse_args().seeds)
    solved = 0
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        for seed in seeds:
            picker = Picker(task, seed)
            solved += picker.pick_and_lift()
            outcome, off = "solved" if picker.success else "FAILED", np.degrees(picker.error)
            print(f"seed {seed}: {outcome}, joints at most {off:.2f} degrees off their trajectory")
    print(f"pick_and_lift: solved {solved} of {len(seeds)}")


if __name__ == "__main__":
    main()
