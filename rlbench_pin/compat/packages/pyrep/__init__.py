"""The simulator and its objects with the API of PyRep, as views on the world of `rlbench_pin`."""

from pyrep.pyrep import PyRep

__all__ = ["PyRep"]
