"""What is wrong with the two files of a task, and in which line."""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterator
from pathlib import Path

from rlbench_pin.builder.document.python_text.mentions import Lookup, lookups
from rlbench_pin.builder.document.python_text.source import Source
from rlbench_pin.builder.document.scene_text.layout import line_of
from rlbench_pin.builder.document.scene_text.scene_text import SceneText
from rlbench_pin.errors import AssetInvalid, AssetNotFound, RlbenchPinError, SceneFileError, nearest_name
from rlbench_pin.scene import SceneSpec, resolve_asset
from rlbench_pin.scene.snapshot import ROOM
from rlbench_pin.tasks import camel_case
from rlbench_pin.urdf import read_urdf
from rlbench_pin.viewer.recording import Problem

_AT_LINE = re.compile(r"\(at line (\d+), column \d+\)")
_ENTRY = re.compile(r"\[\[(\w+)\]\] '(.*?)'(?:, key '(.*?)')?$")
_TABLE = re.compile(r"\[(\w+)\], key '(.*?)'$")
_KEY = re.compile(r"(?:key '(\w+)'|\[\[(\w+)\]\])$")


def scene_problem(text: str, error: RlbenchPinError) -> Problem:
    """Return what `read_scene_text` found wrong with a text, with its line."""
    if isinstance(error, SceneFileError):
        message = f"{error.where}: {error.problem}{f' {error.hint}' if error.hint else ''}"
        return Problem("scene", _scene_line(text, error), message)
    return Problem("scene", _asset_line(text, error), str(error))


def python_problems(source: Source, name: str, spec: SceneSpec | None) -> tuple[Problem, ...]:
    """Return what is wrong with a Python file that can be read: no class of the task, names that the scene lacks."""
    found = [_unknown(lookup, spec) for lookup in lookups(source)] if spec is not None else []
    return (*_class_problem(source, name), *dict.fromkeys(problem for problem in found if problem is not None))


def _scene_line(text: str, error: SceneFileError) -> int | None:
    """Return the line of what an error is about: where the TOML breaks, or the table or key that it names."""
    at = _AT_LINE.search(error.problem)
    if at is not None:
        return int(at[1])
    try:
        scene = SceneText(text, error.file)
    except SceneFileError:
        return text.rstrip("\n").count("\n") + 1 if error.where == "file" else None
    place = _place(scene, error.where)
    return None if place is None else line_of(text, place)


def _place(scene: SceneText, where: str) -> int | None:
    """Return where the table or key stands that an error names."""
    entry, table, key = _ENTRY.match(where), _TABLE.match(where), _KEY.match(where)
    if entry is not None:
        found = [item for item in scene.of_table(entry[1]) if entry[2] in item.names or item.raw.get("name") == entry[2]]
        if not found and (number := re.fullmatch(r"number (\d+)", entry[2])):
            found = list(scene.of_table(entry[1])[int(number[1]) :][:1])
        if not found:
            return None
        last = found[-1]  # of two with one name, the second is wrong
        for key_name in ((entry[3] or "").partition(".")[0], *(("rpy", "poses") if entry[3] == "pose" else ())):
            if (item := last.section.item(key_name)) is not None:
                return item.start
        return last.section.heading
    if table is not None:
        section = scene.section(table[1])
        if section is None:
            return None
        item = section.item(table[2].partition(".")[0])
        return section.heading if item is None else item.start
    if key is not None:
        name = key[1] or key[2]
        item = scene.sections[0].item(name)
        place = next((section.heading for section in scene.sections if section.path[:1] == (name,)), None)
        return item.start if item else place if place is not None else 0
    return None


def _asset_line(text: str, error: RlbenchPinError) -> int | None:
    """Return the line that names a model that is missing or broken, or on whose behalf it is needed."""
    said = str(error.path) if isinstance(error, AssetNotFound | AssetInvalid) else ""
    needed_by = error.needed_by if isinstance(error, AssetNotFound) else ""
    body = re.search(r"body '(.*?)'", needed_by)
    for number, line in enumerate(text.split("\n"), start=1):
        asset = re.match(r"""\s*asset\s*=\s*["'](.*?)["']""", line)
        if asset is not None and (asset[1] == said or said.endswith(asset[1].removeprefix("./")) or asset[1] in needed_by):
            return number
    scene = SceneText(text, Path())
    entry = next((entry for entry in scene.of_table("body") if body is not None and body[1] in entry.names), None)
    return None if entry is None else line_of(text, entry.section.heading)


def _class_problem(source: Source, name: str) -> Iterator[Problem]:
    wanted = camel_case(name)
    classes = [node for node in source.tree.body if isinstance(node, ast.ClassDef)]
    if not any(node.name == wanted for node in classes):
        line = classes[0].lineno if len(classes) == 1 else None
        yield Problem("task", line, f"There is no class '{wanted}'. Name the class of the task after its file, '{name}.py'.")


def _unknown(lookup: Lookup, spec: SceneSpec) -> Problem | None:
    known = _known(lookup.kind, spec)
    wanted = lookup.name.partition("/")[0] if lookup.kind == "graspable" else lookup.name
    if wanted in known:
        return None
    near = nearest_name(wanted, known)
    advice = f"Did you mean '{near}'?" if near else f"Known: {', '.join(sorted(known)[:12]) or 'none'}."
    kind = "body" if lookup.kind == "graspable" else lookup.kind
    return Problem("task", lookup.line, f"The scene has no {kind} '{wanted}'. {advice}")


def _known(kind: str, spec: SceneSpec) -> Collection[str]:
    """Return the names that a look-up of a kind finds."""
    if kind == "body":
        return {*(body.name for body in spec.body), *ROOM}
    if kind == "graspable":
        return {body.name for body in spec.body}
    if kind == "joint":
        return {f"{body.name}/{joint}" for body in spec.body for joint in read_urdf(resolve_asset(spec, body.asset)).joint_limits}
    if kind == "frame":
        return {"root", *(thing.name for thing in (*spec.frame, *spec.region, *spec.sensor, *spec.waypoint))}
    return {thing.name for thing in (spec.region if kind == "region" else spec.sensor)}
