"""The things of a world as users of scene objects see them: one table of names, handles, parents and poses."""

from rlbench_pin.compat.things.element import Element, ObjectType, UnknownObject, UnsupportedCall
from rlbench_pin.compat.things.placed import CameraSettings, Placed
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.compat.things.thing import Thing

__all__ = ["CameraSettings", "Element", "ObjectTable", "ObjectType", "Placed", "Thing", "UnknownObject", "UnsupportedCall"]
