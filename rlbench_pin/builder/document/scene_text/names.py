"""Names in a scene file: free ones, who depends on whom, and renaming everywhere in the file."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import PurePosixPath

from rlbench_pin.builder.document.scene_text.arrays import detached
from rlbench_pin.builder.document.scene_text.edits import replaced
from rlbench_pin.builder.document.scene_text.scene_text import SceneText, Thing
from rlbench_pin.builder.document.scene_text.values import literal
from rlbench_pin.scene.checks import RESERVED

_NUMBERED = re.compile(r"(.*[^0-9])([0-9]{1,9})")


def free_name(wanted: str, taken: Collection[str]) -> str:
    """Return `cup`, or `cup_2`, `cup_3`, ... where it is taken; of `cup4` the next number that is free."""
    used = {*taken, *RESERVED}
    if wanted not in used:
        return wanted
    numbered = _NUMBERED.fullmatch(wanted)
    stem, first = (numbered[1], int(numbered[2]) + 1) if numbered else (f"{wanted}_", 2)
    return next(name for k in range(first, first + len(used) + 1) if (name := f"{stem}{k}") not in used)


def name_from_asset(asset: str) -> str:
    """Return a name for a body of an asset, such as `cup` of `objects/cup/cup.urdf`."""
    words = re.sub(r"[^a-z0-9]+", "_", PurePosixPath(asset).stem.lower()).strip("_")
    return words if words[:1].isalpha() else f"body_{words}".rstrip("_")


def dependants(scene: SceneText, name: str) -> tuple[Thing, ...]:
    """Return what hangs on a thing, and what hangs on that, with the joints of bodies; nearest first."""
    found: list[Thing] = []
    owners = [name]
    while owners:
        owner = owners.pop(0)
        near = [thing for thing in scene.things if thing.parent.partition("/")[0] == owner and thing not in found]
        found += near
        owners += [thing.name for thing in near if thing.table != "joint"]
    return tuple(thing for thing in found if thing.name != name)


def renamed(scene: SceneText, names: Mapping[str, str]) -> SceneText:
    """Return the file with things called otherwise, all at once: names, parents, joints of bodies.

    Args:
        scene: The file.
        names: Old name -> new name.
    """
    for name in names:
        scene = detached(scene, name)
    found = []
    for entry in scene.entries:
        if entry.table in ("deviation", "departure"):
            continue
        for key in ("name", "parent"):
            item, old = entry.section.item(key), entry.raw.get(key)
            if item is None or not isinstance(old, str):
                continue
            owner, slash, rest = old.partition("/")
            is_own_name = key == "name" and entry.table != "joint"
            new = names.get(old, old) if is_own_name else names.get(owner, owner) + slash + rest
            if new != old:
                found.append((*item.value, literal(new)))
    return SceneText(replaced(scene.text, found), scene.path)


def waypoint_shift(scene: SceneText, first: int, by: int) -> dict[str, str]:
    """Return the new names of waypoints when those from one number on move."""
    numbers = range(first, len(scene.of_table("waypoint")))
    return {f"waypoint{k}": f"waypoint{k + by}" for k in numbers}
