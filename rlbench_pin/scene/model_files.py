"""Where the model files of a scene are."""

from __future__ import annotations

from pathlib import Path

from rlbench_pin.assets import asset_path
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.values import as_path, as_text


def resolve_asset(source: SceneSpec | Path | str, asset: str) -> Path:
    """Return the file of an asset: below `assets/`, or beside the scene file when `asset` starts with `./`.

    Args:
        source: The scene that names the asset, or the path of its file.
        asset: As written in the scene, such as `objects/cube/cube.urdf`.
    """
    if not as_text(asset, "asset").startswith(("./", "../")):
        return asset_path(asset)
    file = source.file if isinstance(source, SceneSpec) else source
    return (as_path(file, "source").parent / asset).resolve()
