"""Attachments: a constraint fixes a body to the gripper at its relative pose; contacts with the fingers are off meanwhile."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.sim.body import Body, LoadedModel
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import FloatArray, pose_to_se3, relative, se3_to_pose

_FORCE = 200.0
"""Largest force of an attachment [N]."""


@dataclass(frozen=True, eq=False)
class Attachment:
    """One body that is fixed to the gripper."""

    body: str
    T_hand_body: FloatArray
    """Pose (7,) of the body's base link in the frame of the gripper link."""


class Attachments:
    """The bodies that are fixed to the gripper, in the order in which they were grasped.

    Args:
        robot: The loaded robot.
        description: Names of gripper and fingers.
    """

    def __init__(self, robot: LoadedModel, description: RobotDescription) -> None:
        self._robot, self._client = robot, robot.client
        self._hand = robot.link_index(description.hand_link)
        self._untouched = [robot.link_index(link) for link in fingers_of(description).links]
        hand = bullet.getLinkState(robot.uid, self._hand, physicsClientId=self._client.id)
        self._T_hand_com = pose_to_se3((*hand[2], *hand[3]))
        self._held: dict[str, tuple[Attachment, int, Body]] = {}
        self._pairs_reordered = True

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the held bodies."""
        return tuple(self._held)

    def state(self) -> tuple[Attachment, ...]:
        """The attachments, in order."""
        return tuple(attachment for attachment, _, _ in self._held.values())

    def attach(self, body: Body) -> None:
        """Fix a body to the gripper where it is."""
        hand = self._robot.link_pose_at(self._hand)
        self.add(Attachment(body.name, relative(body.pose, hand)), body)

    def add(self, attachment: Attachment, body: Body) -> None:
        """Fix a body to the gripper at a given relative pose."""
        T_com = self._T_hand_com.inverse() * pose_to_se3(attachment.T_hand_body) * body.model.T_base_com
        frame = se3_to_pose(T_com).tolist()
        constraint = self._client.change(
            bullet.createConstraint,
            self._robot.uid,
            self._hand,
            body.model.uid,
            -1,
            bullet.JOINT_FIXED,
            [0.0, 0.0, 0.0],
            parentFramePosition=frame[:3],
            parentFrameOrientation=frame[3:],
            childFramePosition=[0.0, 0.0, 0.0],
        )
        self._client.change(bullet.changeConstraint, constraint, maxForce=_FORCE)
        self._filter(body, touch=False)
        self._held[body.name] = (attachment, constraint, body)

    def detach(self, name: str) -> None:
        """Release a body."""
        _, constraint, body = self._held.pop(name)
        self._client.change(bullet.removeConstraint, constraint)
        self._filter(body, touch=True)

    def forget_contacts(self, bodies: Iterable[Body]) -> None:
        """Discard PyBullet's contact points between the gripper and bodies that are not attached.

        Some stored contact points have a wrong normal, which would block opening fingers.
        """
        for body in bodies:
            self._filter(body, touch=False)
            self._filter(body, touch=True)

    def restore_order(self, bodies: Iterable[Body]) -> None:
        """Sort PyBullet's collision pairs in the order of `bodies`; the gripper must hold no body.

        Every change of a filter moves the pairs of a body to the end of PyBullet's list, and contacts are solved in that order.
        """
        if not self._pairs_reordered:
            return
        self.forget_contacts(bodies)
        self._pairs_reordered = False

    def _filter(self, body: Body, touch: bool) -> None:
        self._pairs_reordered = True
        for mine in self._untouched:
            for theirs in body.model.links.values():
                self._client.change(bullet.setCollisionFilterPair, self._robot.uid, body.model.uid, mine, theirs, int(touch))
