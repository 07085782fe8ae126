"""The simulated world: PyBullet behind plain names and arrays. Nothing else imports pybullet."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.sim.arm.control import DriveMode
from rlbench_pin.sim.arm.gripper import SimGripper
from rlbench_pin.sim.arm.robot import SimRobot
from rlbench_pin.sim.bodies.body import Body
from rlbench_pin.sim.bodies.joint import ObjectJoint
from rlbench_pin.sim.contacts import Contact
from rlbench_pin.sim.frame import Frame, Posed, Region
from rlbench_pin.sim.render.camera import CameraView, Pictures, look_at
from rlbench_pin.sim.render.egl import RENDERERS, EglMissing, RendererName
from rlbench_pin.sim.render.lighting import Light, Lighting
from rlbench_pin.sim.render.renderer import Request
from rlbench_pin.sim.render.shadows import ShadowMap
from rlbench_pin.sim.render.texture import Texture, read_texture
from rlbench_pin.sim.sensor import Sensor
from rlbench_pin.sim.server.memory import give_back_memory
from rlbench_pin.sim.state import WorldState
from rlbench_pin.sim.world import World

__all__ = [
    "RENDERERS",
    "Body",
    "CameraView",
    "Contact",
    "DriveMode",
    "EglMissing",
    "Frame",
    "Light",
    "Lighting",
    "ObjectJoint",
    "Pictures",
    "Posed",
    "Region",
    "RendererName",
    "Request",
    "Sensor",
    "ShadowMap",
    "SimGripper",
    "SimRobot",
    "Texture",
    "World",
    "WorldState",
    "give_back_memory",
    "look_at",
    "read_texture",
]  # fmt: skip

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
