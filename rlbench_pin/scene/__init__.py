"""What a scene file says: frozen records, reader, writer, snapshot. No physics."""

from __future__ import annotations

from rlbench_pin.scene.model_files import resolve_asset
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.scene.spec import SceneSpec

__all__ = ["SceneSpec", "read_scene", "resolve_asset"]
