"""What a name in a scene stands for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rlbench_pin.errors import RlbenchPinError, UnknownName

Kind = Literal[
    "body", "link", "room", "joint", "root", "frame", "robot", "tip", "gripper", "robot_link", "robot_joint", "camera", "placed"
]
"""Which part of the world answers for a thing."""
ObjectType = Literal["shape", "joint", "dummy", "proximity_sensor", "force_sensor", "vision_sensor", "path"]
"""What users call a thing."""


@dataclass(frozen=True, order=True)
class Element:
    """One thing of a scene: never changes, whatever the thing is called or wherever it stands."""

    kind: Kind
    name: str
    """Name in the world: `<body>`, `<body>/<link>`, `<body>/<joint>`, ..."""


class UnknownObject(UnknownName, RuntimeError):
    """No object of the scene has that name, or it does not exist any more."""


class UnsupportedCall(RlbenchPinError, NotImplementedError):
    """A call that cannot be served here; says what to use instead."""

    def __init__(self, call: str, why: str, instead: str) -> None:
        self.call = call
        super().__init__(f"`{call}` is not available: {why} {instead}")
