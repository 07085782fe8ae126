"""The simulated world, with an interface of names and arrays. Only this package imports pybullet."""

from __future__ import annotations

from rlbench_pin.sim.arm.control import DriveMode, SimRobot
from rlbench_pin.sim.arm.gripper import SimGripper
from rlbench_pin.sim.body import Body, Contact, ObjectJoint
from rlbench_pin.sim.client import RENDERERS, EglMissing, RendererName, give_back_memory
from rlbench_pin.sim.frames import Frame, Posed, Region, Sensor
from rlbench_pin.sim.render.camera import CameraView, Images, field_of_view, framed, look_at
from rlbench_pin.sim.render.image_noise import ImageNoise
from rlbench_pin.sim.render.lighting import Light, Lighting, ShadowMap
from rlbench_pin.sim.render.renderer import Request
from rlbench_pin.sim.render.texture import Texture, read_texture, shaded_texture
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
    "ImageNoise",
    "Images",
    "Light",
    "Lighting",
    "ObjectJoint",
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
    "field_of_view",
    "framed",
    "give_back_memory",
    "look_at",
    "read_texture",
    "shaded_texture",
]
