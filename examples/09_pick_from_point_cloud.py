"""Pick and lift from camera images alone, without the state of the simulator: `python 09_pick_from_point_cloud.py --seeds 0 6`.

cameras -> point cloud -> clusters -> `WorldSnapshot.from_point_cloud` -> `MotionPlanner` -> QP controller. On a real robot the
same code works with the cameras and joints of that robot.

Expected result: the program finds the block with the colour in the instruction among three blocks, avoids the other two, and
moves the block into the ring above the table.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from rlbench_pin import Discrete, Environment, JointVelocity, MoveArmThenGripper, Observation, TaskEnvironment
from rlbench_pin.control import DifferentialIK
from rlbench_pin.environment import image_config
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning import MotionPlanner, Plan, symmetric_poses
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.scene import Box, WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, compose, pose_at
from rlbench_pin.tasks import COLORS

CAMERAS = ("left_shoulder", "right_shoulder", "overhead", "front")
OPEN, CLOSED = 1.0, 0.0
TABLE = ((1.6, 2.0, 0.1), (0.3, 0.0, TABLE_HEIGHT - 0.05))  # sides and middle [m]
ABOVE = pose_at([0.0, 0.0, 0.1])  # [m]
DOWN = pose_at([0.0, 0.0, 0.0], roll=np.pi)  # a gripper that points down
LINK_RADIUS = 0.13  # points nearer than this to the line through the joints belong to the arm [m]
GAP = 0.02  # points nearer than this to each other belong to one object [m]
SETTLE = 10  # control ticks after the end of a trajectory


class PointCloud:
    """Points (n, 3) [m] and colours (n, 3) between 0 and 1."""

    def __init__(self, points: FloatArray, colors: FloatArray) -> None:
        self.points, self.colors = points, colors

    def __getitem__(self, chosen: np.ndarray) -> PointCloud:
        return PointCloud(self.points[chosen], self.colors[chosen])

    @property
    def color(self) -> FloatArray:
        """Median colour of the brighter points, which are lit."""
        brightness = self.colors.sum(axis=1)
        return np.median(self.colors[brightness >= np.percentile(brightness, 75)], axis=0)

    def box(self) -> tuple[FloatArray, FloatArray]:
        """Size and centre of the box around the points [m]."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return high - low, 0.5 * (low + high)


def merge(obs: Observation, model: RobotModel) -> PointCloud:
    """Return the points above the table that all cameras see, without those of the arm."""
    points, colors = [], []
    for camera in CAMERAS:
        depth, misc = getattr(obs, f"{camera}_depth"), obs.misc
        v, u = np.mgrid[0 : depth.shape[0], 0 : depth.shape[1]] + 0.5
        rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ np.linalg.inv(misc[f"{camera}_camera_intrinsics"]).T
        T_world_camera = misc[f"{camera}_camera_extrinsics"]
        points.append((rays * depth.reshape(-1, 1)) @ T_world_camera[:3, :3].T + T_world_camera[:3, 3])
        colors.append(getattr(obs, f"{camera}_rgb").reshape(-1, 3) / 255.0)
    cloud = PointCloud(np.concatenate(points), np.concatenate(colors))
    low, high = np.array([-0.1, -0.6, TABLE_HEIGHT + 0.006]), np.array([0.8, 0.6, TABLE_HEIGHT + 0.8])
    cloud = cloud[((cloud.points > low) & (cloud.points < high)).all(axis=1)]
    joints = [pose[:3] for pose in (*model.joint_poses(obs.joint_positions), model.tip_pose(obs.joint_positions))]
    arm = np.concatenate([np.linspace(a, b, 20) for a, b in zip(joints, joints[1:])])
    return cloud[cKDTree(arm).query(cloud.points)[0] > LINK_RADIUS]


def clusters(cloud: PointCloud) -> list[PointCloud]:
    """Return the objects: points that are connected by steps shorter than `GAP`."""
    tree, left, found = cKDTree(cloud.points), set(range(len(cloud.points))), []
    while left:
        reached = [left.pop()]
        for index in reached:
            near = left.intersection(tree.query_ball_point(cloud.points[index], GAP))
            left -= near
            reached += near
        if len(reached) > 30:
            found.append(cloud[np.array(reached)])
    return found


class Picker:
    """Perception, planning and control from observations and the instruction only."""

    def __init__(self, task: TaskEnvironment, seed: int) -> None:
        self.task, self.rng = task, np.random.default_rng(seed)
        self.model = RobotModel(robot_description("panda"))
        self.planner, self.controller = MotionPlanner(self.model), DifferentialIK(self.model)
        (self.instruction, *_), self.obs = task.reset(seed=seed)
        self.gripper, self.success = OPEN, False

    def pick_and_lift(self) -> bool:
        """Find block and ring, grasp the block from above and move it into the ring."""
        cloud = merge(self.obs, self.model)
        objects = clusters(cloud)
        ring = max(objects, key=lambda found: found.points[:, 2].min())
        wanted = next(np.array(color.rgb) for color in COLORS if f" {color.name} " in self.instruction)
        blocks = [found for found in objects if found is not ring]
        block = min(blocks, key=lambda found: float(np.linalg.norm(found.color - wanted)))
        middle = block.box()[1]
        rest = cloud.points[cKDTree(block.points).query(cloud.points)[0] > 0.01]
        rest = rest[cKDTree(ring.points).query(rest)[0] > 0.01]  # the ring is a mark in the air: the block goes into it

        boxes = {"table": TABLE, "block": block.box()}
        self.see(rest, boxes)
        for plan in self.plan_grasp(middle, heading(block.points)):
            self.follow(plan)
        self.grip(CLOSED)

        self.see(rest, boxes, ["block"])
        self.follow(self.plan(compose(ABOVE, self.obs.gripper_pose), straight=True))
        self.see(rest, {"table": TABLE})
        self.follow(self.plan(symmetric_poses(compose(pose_at(ring.box()[1]), DOWN), 4)))
        return self.success

    def see(self, points: FloatArray, boxes: Mapping[str, Box], attached: Sequence[str] = ()) -> None:
        """Update the world of the planner: points, known boxes, and the held box."""
        q, fingers = self.obs.joint_positions, self.obs.gripper_joint_positions
        self.planner.update(WorldSnapshot.from_point_cloud(points, q, fingers, boxes=boxes, attached=attached, cell=0.015))

    def plan_grasp(self, middle: FloatArray, yaw: float) -> tuple[Plan, Plan]:
        """Plan above the block and straight down to it, with the first rotation of the gripper for which both are possible."""
        refused = []
        for quarter in range(4):
            grasp = compose(pose_at(middle, yaw=yaw + 0.5 * np.pi * quarter), DOWN)
            try:
                above = self.plan(compose(ABOVE, grasp))
                down = self.planner.plan_to_pose(above.path[-1], grasp, straight=True, allowed=["block"], rng=self.rng)
                return above, down
            except PlanningError as error:
                refused.append(error)
        raise refused[0]

    def plan(self, pose: FloatArray | list[FloatArray], straight: bool | None = None) -> Plan:
        """Plan from the present configuration."""
        return self.planner.plan_to_pose(self.obs.joint_positions, pose, straight=straight, rng=self.rng)

    def follow(self, plan: Plan) -> None:
        """Follow the tip poses of a trajectory with a QP controller that keeps the joint limits."""
        dt = self.task.world.control_dt
        ticks = int(np.ceil(plan.trajectory.duration / dt)) + SETTLE
        for tick in range(1, ticks + 1):
            if self.success:
                return
            target = self.model.tip_pose(plan.trajectory.sample(tick * dt)[0])
            self.step(self.controller.velocity_to_pose(self.obs.joint_positions, self.obs.joint_velocities, target))

    def grip(self, gripper: float) -> None:
        """Open or close the gripper."""
        self.gripper = gripper
        self.step(np.zeros(self.model.size))

    def step(self, velocity: FloatArray) -> None:
        """Apply joint velocities for one control tick."""
        self.obs, reward, _ = self.task.step(np.append(velocity, self.gripper))
        self.success = self.success or reward == 1.0


def heading(points: FloatArray) -> float:
    """Return the yaw [rad] of the smallest rectangle around the points from above."""
    yaws = np.linspace(0.0, 0.5 * np.pi, 46)[:-1]
    turned = [points[:, :2] @ np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]) for yaw in yaws]
    return float(yaws[np.argmin([np.prod(np.ptp(flat, axis=0)) for flat in turned])])


def main() -> None:
    """Play the seeds of the command line, one episode each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs=2, type=int, default=[0, 3], metavar=("FIRST", "END"), help="seeds FIRST to END - 1")
    seeds = range(*parser.parse_args().seeds)
    solved = 0
    config = image_config((128, 128), CAMERAS, mask=False)
    for name in CAMERAS:
        config.camera(name).depth_in_meters = True
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config) as environment:
        task = environment.get_task("pick_and_lift")
        for seed in seeds:
            task.set_variation(seed % task.variation_count())
            picker = Picker(task, seed)
            solved += picker.pick_and_lift()
            print(f"seed {seed}: {'solved' if picker.success else 'FAILED'}, {picker.instruction}")
    print(f"pick_and_lift: solved {solved} of {len(seeds)}")


if __name__ == "__main__":
    main()
