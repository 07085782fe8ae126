"""What edits do to the two texts: pure functions from texts to texts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rlbench_pin.builder.document.behaviour.forgetting import without_names
from rlbench_pin.builder.document.errors import EditRefused, HasDependants
from rlbench_pin.builder.document.history import Texts
from rlbench_pin.builder.document.python_text import mentions
from rlbench_pin.builder.document.python_text.source import PythonSyntaxError, Source
from rlbench_pin.builder.document.scene_text import names as scene_names
from rlbench_pin.builder.document.scene_text.arrays import detached, with_pose
from rlbench_pin.builder.document.scene_text.edits import with_entry, with_entry_moved, with_keys, without_entry
from rlbench_pin.builder.document.scene_text.poses import exact_pose_keys
from rlbench_pin.builder.document.scene_text.records import written_keys
from rlbench_pin.builder.document.scene_text.scene_text import PLACEMENT, POSED, TABLES, SceneText
from rlbench_pin.errors import InvalidValue
from rlbench_pin.scene.short_forms import placement_for_file
from rlbench_pin.scene.spec import ROOT, PlacementSpec
from rlbench_pin.values import as_choice, as_text, as_whole


@dataclass(frozen=True)
class Edited:
    """The outcome of an edit."""

    texts: Texts
    """Scene and Python afterwards."""
    name: str = ""
    """Of the thing that it is about."""
    left: tuple[str, ...] = ()
    """Lines of Python that name it in another way, and were left as they are."""


def added(scene: SceneText, python: str, table: str, values: Mapping[str, Any]) -> Edited:
    """Add an entry behind the last of its table."""
    as_choice(table, "table", TABLES)
    if table == "waypoint":
        return waypoint_inserted(scene, python, len(scene.of_table("waypoint")), values)
    name = _name_for(scene, table, values)
    text = _with_new(scene, table, {**values, "name": name})
    return Edited((text, python), name)


def changed(scene: SceneText, python: str, name: str, values: Mapping[str, Any]) -> Edited:
    """Change keys of a thing; those of a joint that the file does not speak of are added."""
    if "/" in as_text(name, "name") and name not in scene.names:
        return added(scene, python, "joint", {**values, "name": name})
    if "name" in values:
        raise EditRefused(f"change the name of '{name}' alone", "others may refer to it.", "Rename it.")
    entry = scene.find(name)
    if entry.is_several and set(values) == {"pose"} and values["pose"] is not None:
        text = with_pose(scene, entry, name, values["pose"])
        if text is not None:
            return Edited((text, python), name)
    alone = detached(scene, name)
    entry = alone.find(name)
    keys = written_keys(entry.table, values, entry.raw, short_forms=scene.has_short_forms)
    return Edited((with_keys(alone, entry, keys) if keys else scene.text, python), name)


def placement_changed(scene: SceneText, python: str, values: Mapping[str, Any]) -> Edited:
    """Change keys of `[placement]`; a pose is meant in the world."""
    scene.refuse_inline("change the placement", PLACEMENT)
    section = scene.section(PLACEMENT)
    pose = values.get("pose")
    if pose is not None and scene.has_short_forms:
        pose = placement_for_file(PlacementSpec(pose=pose)).pose
    said = {**values, "pose": pose} if "pose" in values else dict(values)
    keys = written_keys(PLACEMENT, said, scene.raw.get(PLACEMENT, {}), short_forms=scene.has_short_forms)
    if not keys:
        return Edited((scene.text, python), PLACEMENT)
    text = with_keys(scene, section, keys) if section is not None else with_entry(scene, PLACEMENT, keys)
    return Edited((text, python), PLACEMENT)


def duplicated(scene: SceneText, python: str, name: str) -> Edited:
    """Add a thing like another, with the joints of a body, at the same place."""
    entry = scene.find(name)
    if entry.table == "joint":
        raise EditRefused(f"duplicate '{name}'", "a joint is described once.", "Duplicate its body.")
    entry = detached(scene, name).find(name)
    keys = {key: value for key, value in entry.raw.items() if key != "name"}
    if entry.table == "waypoint":
        return _inserted_as_written(scene, python, _number(name) + 1, keys)
    new = scene_names.free_name(name, scene.names)
    scene.refuse_inline(f"duplicate '{name}'", entry.table)
    text = with_entry(scene, entry.table, {**keys, "name": new})
    for joint in scene.of_table("joint"):
        body, _, rest = str(joint.raw.get("name")).partition("/")
        if body == name:
            text = with_entry(SceneText(text, scene.path), "joint", {**joint.raw, "name": f"{new}/{rest}"})
    return Edited((text, python), new)


def deleted(scene: SceneText, python: str, name: str, *, with_dependants: bool = False) -> Edited:
    """Take a thing away, perhaps with all that hangs on it and what forms say of them; waypoints behind one are renumbered."""
    scene.find(name)
    hanging = scene_names.dependants(scene, name)
    source = _source_or_none(python)
    lines = mentions.mentions(source, name) if source is not None else ()
    if (hanging or lines) and not with_dependants:
        raise HasDependants(name, [thing.name for thing in hanging], lines)
    doomed = {name, *(thing.name for thing in hanging)}
    points = sorted((_number(n) for n in doomed if scene.find(n).table == "waypoint"), reverse=True)
    for other in sorted(doomed - {f"waypoint{k}" for k in points}):
        scene = detached(scene, other)
        scene = SceneText(without_entry(scene, scene.find(other)), scene.path)
    python = without_names(python, doomed)
    source = _source_or_none(python)
    left = [line for other in sorted(doomed) for line in mentions.mentions(source, other)] if source is not None else []
    for number in points:
        gone = SceneText(without_entry(scene, scene.find(f"waypoint{number}")), scene.path)
        shift = {f"waypoint{k}": f"waypoint{k - 1}" for k in range(number + 1, len(scene.of_table("waypoint")))}
        scene, python, more = _renumbered(gone, python, shift)
        left += more
    return Edited((scene.text, python), name, tuple(dict.fromkeys(left)))


def waypoint_inserted(scene: SceneText, python: str, index: int, values: Mapping[str, Any]) -> Edited:
    """Add a waypoint before the one of that number; those behind move up by one, wherever they are named."""
    keys = written_keys("waypoint", {k: v for k, v in values.items() if k != "name"}, {}, short_forms=scene.has_short_forms)
    return _inserted_as_written(scene, python, index, keys)


def waypoint_moved(scene: SceneText, python: str, name: str, index: int) -> Edited:
    """Have a waypoint visited as the one of that number; what is said of it moves there in the text, too."""
    edit, points = f"reorder '{name}'", scene.of_table("waypoint")
    if scene.find(name).table != "waypoint":
        raise EditRefused(edit, "it is no waypoint.")
    last = sum(len(entry.names) for entry in points) - 1
    if as_whole(index, "index", least=0) > last:
        raise InvalidValue("index", index, f"has to be 0 to {last}, a number of a waypoint")
    old = _number(name)
    if index == old:
        return Edited((scene.text, python), name)
    if lines := mentions.computed_waypoints(_source(python, edit)):
        problem = f"the Python computes which waypoint it means, in line {', in line '.join(lines)}."
        raise EditRefused(edit, problem, "Write names or numbers out there, or renumber both files in *Files*.")
    first, end = min(old, index), max(old, index)
    for k in range(first, end + 1):
        scene = detached(scene, f"waypoint{k}")
    goal = scene.find(f"waypoint{index}")
    text = with_entry_moved(scene, scene.find(name), goal.section.start if index < old else goal.end)
    by = 1 if index < old else -1
    shift = {f"waypoint{k}": f"waypoint{k + by}" for k in range(first, end + 1) if k != old} | {name: f"waypoint{index}"}
    moved, python, left = _renumbered(SceneText(text, scene.path), python, shift)
    return Edited((moved.text, python), f"waypoint{index}", left)


def attached(scene: SceneText, python: str, name: str, parent: str, pose: Any) -> Edited:
    """Hang a thing on another, at a pose in its frame that is exact to 1e-9."""
    scene = detached(scene, name)
    entry = scene.find(name)
    if entry.table not in POSED:
        raise EditRefused(f"hang '{name}' on '{parent}'", "it has no pose.", "Choose a body, frame, region, sensor or waypoint.")
    place = exact_pose_keys(pose, has_rpy=scene.has_short_forms)
    keys = {"parent": None if as_text(parent, "parent") == ROOT else parent, **place}
    said = {key: value for key, value in keys.items() if not (value is None and key not in entry.raw)}
    return Edited((with_keys(scene, entry, said), python), name)


def renamed(scene: SceneText, python: str, old: str, new: str) -> Edited:
    """Call a thing otherwise, wherever it is named."""
    entry = scene.find(old)
    if entry.table == "joint":
        raise EditRefused(f"rename '{old}'", "the name of a joint is in the URDF file of its body.", "Rename the body.")
    if as_text(new, "new name") in scene.names:
        raise EditRefused(f"rename '{old}'", f"'{new}' is used already.", "Choose another name.")
    text, left = mentions.renamed(_source(python, f"rename '{old}'"), {old: new})
    return Edited((scene_names.renamed(scene, {old: new}).text, text), new, left)


def _inserted_as_written(scene: SceneText, python: str, index: int, keys: Mapping[str, Any]) -> Edited:
    count = len(scene.of_table("waypoint"))
    scene.refuse_inline("add a waypoint", "waypoint")
    if as_whole(index, "index", least=0) > count:
        raise InvalidValue("index", index, f"has to be 0 to {count}, the number of waypoints")
    shift = scene_names.waypoint_shift(scene, index, 1)
    moved, python, left = _renumbered(scene, python, shift)
    parent = keys.get("parent")
    parent = shift.get(parent, parent) if isinstance(parent, str) else parent
    behind = moved.find(f"waypoint{index + 1}") if index < count else None
    name = f"waypoint{index}"
    text = with_entry(moved, "waypoint", {**keys, "parent": parent, "name": name}, behind)
    return Edited((text, python), name, left)


def _renumbered(scene: SceneText, python: str, shift: Mapping[str, str]) -> tuple[SceneText, str, tuple[str, ...]]:
    if not shift:
        return scene, python, ()
    python, left = mentions.renamed(_source(python, "renumber the waypoints"), shift)
    return scene_names.renamed(scene, shift), python, left


def _with_new(scene: SceneText, table: str, values: Mapping[str, Any]) -> str:
    scene.refuse_inline(f"add a {table}", table)
    return with_entry(scene, table, written_keys(table, values, {}, short_forms=scene.has_short_forms))


def _name_for(scene: SceneText, table: str, values: Mapping[str, Any]) -> str:
    """Return the name of a new thing: the one that is wanted, or a free one."""
    wanted = values.get("name")
    if wanted is None and table in ("joint", "deviation", "departure"):
        raise InvalidValue("name", wanted, f"has to be given for a {table}")
    if wanted is None:
        stem = scene_names.name_from_asset(as_text(values.get("asset"), "asset")) if table == "body" else table
        return scene_names.free_name(stem, scene.names)
    return as_text(wanted, "name")


def _number(waypoint: str) -> int:
    """Return the number of a waypoint."""
    digits = waypoint.removeprefix("waypoint")
    if not digits.isdecimal():
        raise EditRefused("renumber the waypoints", f"'{waypoint}' has no number.", "Mend its name in the text.")
    return int(digits)


def _source(python: str, edit: str) -> Source:
    try:
        return Source(python)
    except PythonSyntaxError as error:
        raise EditRefused(edit, f"the Python cannot be read, {error}.", "Mend it first.") from error


def _source_or_none(python: str) -> Source | None:
    try:
        return Source(python)
    except PythonSyntaxError:
        return None
