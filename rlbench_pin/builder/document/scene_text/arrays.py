"""Arrays of things, one for each of `poses`: one pose is changed in place; a thing that differs gets an entry of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rlbench_pin.builder.document.scene_text.edits import heading_of, lines_of, replaced, with_keys
from rlbench_pin.builder.document.scene_text.layout import Item, elements
from rlbench_pin.builder.document.scene_text.poses import pose_keys, short_pose
from rlbench_pin.builder.document.scene_text.scene_text import Entry, SceneText
from rlbench_pin.builder.document.scene_text.values import literal


def with_pose(scene: SceneText, entry: Entry, name: str, pose: list[float]) -> str | None:
    """Return the text with one of the poses of an array changed; None when the array cannot say it."""
    index = entry.names.index(name)
    written = entry.raw["poses"][index]
    if "rpy" in entry.raw:
        found = pose_keys(pose, {"pose": written, "rpy": entry.raw["rpy"]}, has_rpy=True)
        if "rpy" in found or len(found.get("pose") or ()) not in (0, 3):
            return None
        new = (found["pose"] or [0.0, 0.0, 0.0]) if "pose" in found else written
    else:
        new = short_pose(pose, written)
    poses = [*entry.raw["poses"]]
    poses[index] = new
    return with_keys(scene, entry, {"poses": poses})


def detached(scene: SceneText, name: str) -> SceneText:
    """Return the file in which a thing has an entry of its own; the array that it was in is split."""
    entry = scene.find(name)
    if not entry.is_several:
        return scene
    index = entry.names.index(name)
    if len(entry.names) == 1:
        return SceneText(with_keys(scene, entry, {"poses": None, "pose": entry.raw["poses"][0]}), scene.path)
    before, behind = slice(0, index), slice(index + 1, None)
    single = _block(entry, slice(index, index + 1))
    if index == 0:
        kept, new = behind, [single, ""]
    else:
        kept, new = before, ["", single, *([_block(entry, behind)] if entry.names[behind] else [])]
    changed = _shortened(scene, entry, kept)
    grown = len(changed) - len(scene.text)
    rest = changed[entry.section.start : entry.end + grown]
    blocks = [block or rest for block in new]
    joined = "\n".join(block if block.endswith("\n") else f"{block}\n" for block in blocks)
    return SceneText(f"{changed[: entry.section.start]}{joined}{changed[entry.end + grown :]}", scene.path)


def _shortened(scene: SceneText, entry: Entry, kept: slice) -> str:
    """Return the text in which an array has some of its things only."""
    names, poses = entry.names[kept], entry.raw["poses"][kept]
    item, called = entry.section.item("poses"), entry.section.item("name")
    assert item is not None and called is not None
    changes: dict[str, Any] = {"name": names[0]}
    if len(names) == 1:
        return with_keys(scene, entry, {**changes, "poses": None, "pose": poses[0]})
    named = with_keys(scene, entry, changes)
    grown = len(named) - len(scene.text) if called.start < item.start else 0
    start, end = item.value
    return replaced(named, [(start + grown, end + grown, _fewer(scene.text, item, kept) or literal(poses, 8))])


def _fewer(text: str, item: Item, kept: slice) -> str:
    """Return some elements of an array as they are written, where that is a piece of it."""
    places = elements(text, item.value[0])
    chosen = places[kept]
    if len(chosen) == len(places):
        return text[slice(*item.value)]
    head = text[item.value[0] : places[0][0]]
    tail = text[places[-1][1] : item.value[1]]
    return f"{head}{text[chosen[0][0] : chosen[-1][1]]}{tail}"


def _block(entry: Entry, part: slice) -> str:
    """Return the text of a new entry for some things of an array."""
    names, poses = entry.names[part], entry.raw["poses"][part]
    said: Mapping[str, Any] = {"pose": poses[0]} if len(names) == 1 else {"poses": poses}
    return f"{heading_of(entry.table)}\n{lines_of({**entry.raw, 'poses': None, **said, 'name': names[0]})}"
