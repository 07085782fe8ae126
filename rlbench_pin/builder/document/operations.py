"""Edits of the scene as pure functions from texts to texts; the Python follows where it names elements of the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rlbench_pin.builder.document.behaviour import without_names
from rlbench_pin.builder.document.errors import EditRefused, HasDependants
from rlbench_pin.builder.document.python_text import (
    PythonSyntaxError,
    Source,
    computed_waypoints,
    mentions,
    renamed_in_python,
    source_or_none,
)
from rlbench_pin.builder.document.scene_text import (
    PLACEMENT,
    Entry,
    SceneText,
    dependants,
    detached,
    free_name,
    name_from_asset,
    renamed,
    with_array_pose,
    with_entry,
    with_entry_moved,
    with_keys,
    without_entry,
)
from rlbench_pin.builder.document.scene_values import exact_pose_keys, written_keys
from rlbench_pin.builder.document.texts import Texts
from rlbench_pin.errors import InvalidValue
from rlbench_pin.scene.reader import POSED_TABLES, placement_for_file
from rlbench_pin.scene.spec import ROOT, PlacementSpec
from rlbench_pin.scene.writer import TABLES
from rlbench_pin.values import as_choice, as_several, as_text, as_whole

INSTRUCTIONS = "instructions"
"""The table of sentences."""


@dataclass(frozen=True)
class Edited:
    """The outcome of an edit.

    Attributes:
        texts: Scene and Python afterwards.
        name: Name of the element.
        left: Lines of Python that name it in a way that cannot be renamed; they did not change.
    """

    texts: Texts
    name: str
    left: tuple[str, ...] = ()


def added(scene: SceneText, python: str, table: str, values: Mapping[str, Any]) -> Edited:
    """Add an element after the last one of its table."""
    as_choice(table, "table", tuple(TABLES))
    if table == "waypoint":
        return waypoint_inserted(scene, python, len(scene.of_table("waypoint")), values)
    name = values.get("name")
    if name is None and table in ("joint", "deviation"):
        raise InvalidValue("name", name, f"has to be given for a {table}")
    if name is None:
        stem = name_from_asset(as_text(values.get("asset"), "asset")) if table == "body" else table
        name = free_name(stem, scene.names)
    name = as_text(name, "name")
    scene.refuse_inline(f"add a {table}", table)
    keys = written_keys(table, {**values, "name": name}, {}, short_forms=scene.has_short_forms)
    return Edited((with_entry(scene, table, keys), python), name)


def changed(scene: SceneText, python: str, name: str, values: Mapping[str, Any]) -> Edited:
    """Change keys of an element; a joint that has no entry gets one."""
    if "/" in as_text(name, "name") and name not in scene.names:
        return added(scene, python, "joint", {**values, "name": name})
    if "name" in values:
        raise EditRefused(f"change only the key name of '{name}'", "other elements may refer to it.", "Use rename.")
    entry = scene.find(name)
    if entry.is_array and set(values) == {"pose"} and values["pose"] is not None:
        text = with_array_pose(scene, entry, name, values["pose"])
        if text is not None:
            return Edited((text, python), name)
    alone = detached(scene, name)
    entry = alone.find(name)
    keys = written_keys(entry.table, values, entry.raw, short_forms=scene.has_short_forms)
    return Edited((with_keys(alone, entry, keys) if keys else scene.text, python), name)


def placement_changed(scene: SceneText, python: str, key: str, value: Any) -> Edited:
    """Change a key of `[placement]`; a pose is given in the world."""
    scene.refuse_inline("change the placement", PLACEMENT)
    if key == "pose" and value is not None and scene.has_short_forms:
        value = placement_for_file(PlacementSpec(pose=value)).pose
    section, raw = scene.section(PLACEMENT), scene.raw.get(PLACEMENT, {})
    keys = written_keys(PLACEMENT, {key: value}, raw, short_forms=scene.has_short_forms)
    if not keys:
        return Edited((scene.text, python), PLACEMENT)
    if section is None:
        return Edited((with_entry(scene, PLACEMENT, keys), python), PLACEMENT)
    return Edited((with_keys(scene, Entry(PLACEMENT, section, raw), keys), python), PLACEMENT)


def sentences_changed(scene: SceneText, python: str, groups: Sequence[Sequence[str]]) -> Edited:
    """Change the training sentences of `[instructions]`: one group of templates for all variations."""
    if len(as_several(groups, INSTRUCTIONS)) != 1:
        raise EditRefused(
            "change instructions", "the scene has one list for all variations.", "Use words such as `{color}` in it."
        )
    scene.refuse_inline("change instructions", INSTRUCTIONS)
    section = scene.section(INSTRUCTIONS)
    assert section is not None, "it was read from there"
    sentences = [as_text(sentence, "sentence") for sentence in as_several(groups[0], INSTRUCTIONS)]
    entry = Entry(INSTRUCTIONS, section, scene.raw[INSTRUCTIONS])
    return Edited((with_keys(scene, entry, {"training": sentences}), python), INSTRUCTIONS)


def duplicated(scene: SceneText, python: str, name: str) -> Edited:
    """Add a copy of an element at the same place, with the joints of a body."""
    entry = scene.find(name)
    if entry.table == "joint":
        raise EditRefused(f"duplicate '{name}'", "a joint is described once.", "Duplicate its body.")
    entry = detached(scene, name).find(name)
    keys = {key: value for key, value in entry.raw.items() if key != "name"}
    if entry.table == "waypoint":
        return _inserted(scene, python, _number(name) + 1, keys)
    new = free_name(name, scene.names)
    scene.refuse_inline(f"duplicate '{name}'", entry.table)
    text = with_entry(scene, entry.table, {**keys, "name": new})
    for joint in scene.of_table("joint"):
        body, _, rest = str(joint.raw.get("name")).partition("/")
        if body == name:
            text = with_entry(SceneText(text, scene.path), "joint", {**joint.raw, "name": f"{new}/{rest}"})
    return Edited((text, python), new)


def deleted(scene: SceneText, python: str, name: str, with_dependants: bool) -> Edited:
    """Delete an element, perhaps with its descendants and all conditions that name them; later waypoints are renumbered."""
    scene.find(name)
    hanging = dependants(scene, name)
    lines = mentions(source_or_none(python), name)
    if (hanging or lines) and not with_dependants:
        raise HasDependants(name, [element.name for element in hanging], lines)
    doomed = {name, *(element.name for element in hanging)}
    points = sorted((_number(n) for n in doomed if scene.find(n).table == "waypoint"), reverse=True)
    for other in sorted(doomed - {f"waypoint{k}" for k in points}):
        scene = detached(scene, other)
        scene = SceneText(without_entry(scene, scene.find(other)), scene.path)
    python = without_names(python, doomed)
    source = source_or_none(python)
    left = [line for other in sorted(doomed) for line in mentions(source, other)]
    for number in points:
        gone = SceneText(without_entry(scene, scene.find(f"waypoint{number}")), scene.path)
        shift = {f"waypoint{k}": f"waypoint{k - 1}" for k in range(number + 1, len(scene.of_table("waypoint")))}
        scene, python, more = _renumbered(gone, python, shift)
        left += more
    return Edited((scene.text, python), name, tuple(dict.fromkeys(left)))


def waypoint_inserted(scene: SceneText, python: str, index: int, values: Mapping[str, Any]) -> Edited:
    """Add a waypoint before the one of that number; later ones move up by one, wherever they are named."""
    keys = written_keys("waypoint", {k: v for k, v in values.items() if k != "name"}, {}, short_forms=scene.has_short_forms)
    return _inserted(scene, python, index, keys)


def waypoint_moved(scene: SceneText, python: str, name: str, index: int) -> Edited:
    """Give a waypoint another number; its entry moves to that place in the text."""
    edit, points = f"reorder '{name}'", scene.of_table("waypoint")
    if scene.find(name).table != "waypoint":
        raise EditRefused(edit, "it is not a waypoint.", "Choose a waypoint.")
    last = sum(len(entry.names) for entry in points) - 1
    if as_whole(index, "index", least=0) > last:
        raise InvalidValue("index", index, f"has to be 0 to {last}, a number of a waypoint")
    old = _number(name)
    if index == old:
        return Edited((scene.text, python), name)
    _refuse_computed(python, edit)
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
    """Give an element another parent, and a pose in its frame that is exact to 1e-9."""
    scene = detached(scene, name)
    entry = scene.find(name)
    if entry.table not in POSED_TABLES:
        raise EditRefused(
            f"attach '{name}' to '{parent}'", "it has no pose.", "Choose a body, frame, region, sensor or waypoint."
        )
    place = exact_pose_keys(pose, has_rpy=scene.has_short_forms)
    keys = {"parent": None if as_text(parent, "parent") == ROOT else parent, **place}
    keys = {key: value for key, value in keys.items() if value is not None or key in entry.raw}
    return Edited((with_keys(scene, entry, keys), python), name)


def renamed_everywhere(scene: SceneText, python: str, old: str, new: str) -> Edited:
    """Rename an element wherever it is named."""
    if scene.find(old).table == "joint":
        raise EditRefused(f"rename '{old}'", "the name of a joint is in the URDF file of its body.", "Rename the body.")
    if as_text(new, "new name") in scene.names:
        raise EditRefused(f"rename '{old}'", f"'{new}' is already in use.", "Choose another name.")
    text, left = renamed_in_python(_source(python, f"rename '{old}'"), {old: new})
    return Edited((renamed(scene, {old: new}).text, text), new, left)


def _inserted(scene: SceneText, python: str, index: int, keys: Mapping[str, Any]) -> Edited:
    """Insert a waypoint whose keys are as in the file."""
    count = len(scene.of_table("waypoint"))
    scene.refuse_inline("add a waypoint", "waypoint")
    if as_whole(index, "index", least=0) > count:
        raise InvalidValue("index", index, f"has to be 0 to {count}, the number of waypoints")
    if index < count:
        _refuse_computed(python, f"add a waypoint before waypoint{index}")
    shift = {f"waypoint{k}": f"waypoint{k + 1}" for k in range(index, count)}
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
    python, left = renamed_in_python(_source(python, "renumber the waypoints"), shift)
    return renamed(scene, shift), python, left


def _refuse_computed(python: str, edit: str) -> None:
    """Refuse an edit that gives waypoints other numbers where the Python computes them."""
    if lines := computed_waypoints(_source(python, edit)):
        problem = f"the Python computes which waypoint it means, in line {', in line '.join(lines)}."
        raise EditRefused(edit, problem, "Write literal names or numbers there, or renumber both files in *Files*.")


def _number(waypoint: str) -> int:
    digits = waypoint.removeprefix("waypoint")
    if not digits.isdecimal():
        raise EditRefused("renumber the waypoints", f"'{waypoint}' has no number.", "Correct its name in the text.")
    return int(digits)


def _source(python: str, edit: str) -> Source:
    try:
        return Source(python)
    except PythonSyntaxError as error:
        raise EditRefused(edit, f"the Python cannot be read, {error}.", "Correct it first.") from error
