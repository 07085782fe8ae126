"""Scene files: frozen records, reader, writer, snapshot. No physics."""

from __future__ import annotations

from rlbench_pin.scene.reader import read_scene, read_scene_text, resolve_asset
from rlbench_pin.scene.snapshot import BodySnapshot, Box, Shape, WorldSnapshot
from rlbench_pin.scene.spec import (
    BodySpec,
    DeviationSpec,
    ExcludedFactorSpec,
    FrameSpec,
    HistorySpec,
    InstructionsSpec,
    JointSpec,
    PlacementSpec,
    RegionSpec,
    SceneSpec,
    SensorSpec,
    WaypointSpec,
)
from rlbench_pin.scene.writer import write_scene

__all__ = [
    "BodySnapshot",
    "BodySpec",
    "Box",
    "DeviationSpec",
    "ExcludedFactorSpec",
    "FrameSpec",
    "HistorySpec",
    "InstructionsSpec",
    "JointSpec",
    "PlacementSpec",
    "RegionSpec",
    "SceneSpec",
    "SensorSpec",
    "Shape",
    "WaypointSpec",
    "WorldSnapshot",
    "read_scene",
    "read_scene_text",
    "resolve_asset",
    "write_scene",
]
