"""The objects of a world for `pyrep`: one table of names, handles, parents and poses."""

from rlbench_pin.compat.objects.elements import Element, ObjectType, UnknownObject, UnsupportedCall
from rlbench_pin.compat.objects.scene_objects import CameraSettings, Placed, SceneObject
from rlbench_pin.compat.objects.table import ObjectTable

__all__ = ["CameraSettings", "Element", "ObjectTable", "ObjectType", "Placed", "SceneObject", "UnknownObject", "UnsupportedCall"]
