"""Where the model files of a scene are, and the names inside them: links, movable joints, meshes. No model is built."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.scene.spec import SceneSpec

UNBOUNDED = (float("-inf"), float("inf"))


@dataclass(frozen=True)
class UrdfNames:
    """What a scene file may refer to in one URDF."""

    links: tuple[str, ...]
    joints: Mapping[str, tuple[float, float]]
    """Movable joint -> lower and upper limit [m] or [rad]."""
    files: tuple[Path, ...]
    """Meshes and textures that the URDF needs."""


def resolve_asset(source: SceneSpec | Path | str, asset: str) -> Path:
    """Return the file of an asset: below `assets/`, or beside the scene file when `asset` starts with `./`.

    Args:
        source: The scene that names the asset, or the path of its file.
        asset: As written in the scene, such as `objects/cube/cube.urdf`.
    """
    if not asset.startswith(("./", "../")):
        return asset_path(asset)
    file = source.file if isinstance(source, SceneSpec) else source
    return (Path(file).parent / asset).resolve()


@lru_cache(maxsize=256)
def urdf_names(path: Path) -> UrdfNames:
    """Read the names of one URDF file.

    Raises:
        AssetNotFound: The file does not exist.
        AssetInvalid: The file is not XML.
    """
    if not path.is_file():
        raise AssetNotFound(path, "a scene")
    try:
        robot = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise AssetInvalid(path, f"it is not valid XML ({error})") from error
    links = tuple(link.get("name", "") for link in robot.findall("link"))
    movable = (joint for joint in robot.findall("joint") if joint.get("type") != "fixed")
    joints = {joint.get("name", ""): _limits(joint) for joint in movable}
    names = (element.get("filename", "") for tag in ("mesh", "texture") for element in robot.iter(tag))
    files = tuple(dict.fromkeys(path.parent / name for name in names if name))
    return UrdfNames(links, MappingProxyType(joints), files)


def _limits(joint: ET.Element) -> tuple[float, float]:
    limit = joint.find("limit")
    if limit is None or joint.get("type") == "continuous":
        return UNBOUNDED
    return float(limit.get("lower", "0")), float(limit.get("upper", "0"))
