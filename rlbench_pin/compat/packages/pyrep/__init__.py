"""The simulator and its objects under names that programs know, as views on the world of `rlbench_pin`."""

from pyrep.pyrep import PyRep

__all__ = ["PyRep"]
