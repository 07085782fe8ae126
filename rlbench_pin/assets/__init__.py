"""Assets: objects, robots, textures. `asset_path` returns the file of a name in a scene file."""

from __future__ import annotations

from pathlib import Path

ASSETS = Path(__file__).parent


def asset_path(name: str) -> Path:
    """Return the absolute path of `objects/<name>/<name>.urdf`, `robots/...` or `textures/...`."""
    return ASSETS / name
