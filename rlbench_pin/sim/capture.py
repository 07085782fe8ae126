"""World -> WorldSnapshot: what planning needs of this instant."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rlbench_pin.scene.snapshot import BodySnapshot, WorldSnapshot
from rlbench_pin.sim.arm.gripper import SimGripper
from rlbench_pin.sim.arm.robot import SimRobot
from rlbench_pin.sim.bodies.body import Body


def capture(room: Iterable[Body], bodies: Iterable[Body], robot: SimRobot, gripper: SimGripper) -> WorldSnapshot:
    """Return names, model files, link poses and joint values as they are now.

    Args:
        room: Table, floor and walls; like `bodies`, those without collision geometry are left out.
        bodies: Everything else but the robot.
        robot: Its arm and fingers.
        gripper: What it holds.
    """
    seen = [capture_body(body, in_room=True) for body in room] + [capture_body(body) for body in bodies]
    return WorldSnapshot(tuple(b for b in seen if b.link_names), robot.joint_positions, robot.fingers, gripper.grasped)


def capture_body(body: Body, in_room: bool = False) -> BodySnapshot:
    """Return where the colliding links of one body are now."""
    links = body.model.collision_links()
    poses = np.array([body.link_pose(link) for link in links]).reshape(-1, 7)
    model = body.model
    collides = body.collides and body.obstacle
    return BodySnapshot(body.name, model.urdf, links, poses, model.scale, collides, body.fixed, in_room=in_room)
