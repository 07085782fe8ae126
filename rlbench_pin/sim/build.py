"""Loading robot, room and the bodies of a scene into a physics server."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import RobotModelError
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.model_files import resolve_asset
from rlbench_pin.scene.snapshot import ROOM
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim.bodies.body import Body, OnMove
from rlbench_pin.sim.bodies.model import LoadedModel, inspect
from rlbench_pin.sim.bodies.room import RoomBody
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.spatial import IDENTITY


def load_robot(client: PhysicsClient, description: RobotDescription) -> LoadedModel:
    """Load the arm, fixed at its base pose.

    Raises:
        RobotModelError: Its hand has not two fingers.
    """
    if (fingers := len(description.gripper_joints)) != 2:
        raise RobotModelError(
            f"The simulation drives a hand with two fingers; '{description.name}' has {fingers} gripper joints. "
            "Describe a hand with two, or use this arm for planning and control alone."
        )
    uid = client.load(description.urdf, f"robot '{description.name}'", np.array(description.base_pose), fixed=True)
    return inspect(client, uid, description.urdf, 1.0)


def load_room(client: PhysicsClient, on_move: OnMove) -> dict[str, RoomBody]:
    """Load table, floor, walls and ceiling; their files are in world coordinates."""
    return {name: _room_body(client, name, on_move) for name in ROOM}


def _room_body(client: PhysicsClient, name: str, on_move: OnMove) -> RoomBody:
    urdf = asset_path(f"room/{name}.urdf")
    uid = client.load(urdf, "the room", IDENTITY, fixed=True)
    return RoomBody(name, inspect(client, uid, urdf, 1.0), fixed=True, collides=True, on_move=on_move).hide()


def load_body(client: PhysicsClient, spec: BodySpec, scene_file: str, on_move: OnMove) -> Body:
    """Load one body of a scene at the world origin; its place is set afterwards."""
    urdf = resolve_asset(Path(scene_file), spec.asset)
    uid = client.load(urdf, f"body '{spec.name}'", IDENTITY, spec.fixed, spec.scale)
    body = Body(spec.name, inspect(client, uid, urdf, spec.scale), fixed=spec.fixed, collides=spec.collides, on_move=on_move)
    if spec.color is not None:
        body.set_color(spec.color)
    return body


def share_island(robot: LoadedModel, body: Body) -> None:
    """Have a body with joints solved in one go with the arm: a constraint without force ties the two together.

    PyBullet sorts the constraints of joints, and the contacts between the same two links of several convex parts, by islands, in
    an order that leaves those of one island in no fixed sequence as soon as there are two. Islands come and go with contacts
    and with what was simulated before, so the same motion would differ in the last bits from one run to the next. With one
    island there is nothing to sort.
    """
    link = min(joint.index for joint in body.model.joints.values())
    zero = [0.0, 0.0, 0.0]
    change = robot.client.change
    tie = change(bullet.createConstraint, robot.uid, 0, body.model.uid, link, bullet.JOINT_POINT2POINT, zero, zero, zero)
    change(bullet.changeConstraint, tie, maxForce=0.0)
