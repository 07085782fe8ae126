"""Problems of the two files of a task, each with its line."""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterator
from pathlib import Path

from rlbench_pin.builder.document.python_text import Lookup, PythonSyntaxError, Source, lookups
from rlbench_pin.builder.document.scene_text import SceneText
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
    """Return the problem of a scene file, with its line."""
    if isinstance(error, SceneFileError):
        message = f"{error.where}: {error.problem}{f' {error.hint}' if error.hint else ''}"
        return Problem("scene", _scene_line(text, error), message)
    return Problem("scene", _asset_line(text, error), str(error))


def python_problems(text: str, name: str, spec: SceneSpec | None) -> Iterator[Problem]:
    """Yield the problems of a Python file: syntax, no class of the task, names that the scene lacks (unless `spec` is None)."""
    try:
        source = Source(text)
    except PythonSyntaxError as error:
        yield Problem("task", error.line, f"This is not valid Python: {error.problem}.")
        return
    wanted = camel_case(name)
    classes = [node for node in source.tree.body if isinstance(node, ast.ClassDef)]
    if not any(node.name == wanted for node in classes):
        line = classes[0].lineno if len(classes) == 1 else None
        yield Problem("task", line, f"There is no class '{wanted}'. Name the class of the task after its file, '{name}.py'.")
    found = [_unknown(lookup, spec) for lookup in lookups(source)] if spec is not None else []
    yield from dict.fromkeys(problem for problem in found if problem is not None)


def _scene_line(text: str, error: SceneFileError) -> int | None:
    """Return the line that an error is about: where the TOML breaks, or the table or key that it names."""
    at = _AT_LINE.search(error.problem)
    if at is not None:
        return int(at[1])
    try:
        scene = SceneText(text, error.file)
    except SceneFileError:
        return text.rstrip("\n").count("\n") + 1 if error.where == "file" else None
    place = _place(scene, error.where)
    return None if place is None else _line_of(text, place)


def _place(scene: SceneText, where: str) -> int | None:
    """Return the place of the table or key that an error names."""
    entry, table, key = _ENTRY.match(where), _TABLE.match(where), _KEY.match(where)
    if entry is not None:
        found = [item for item in scene.of_table(entry[1]) if entry[2] in item.names or item.raw.get("name") == entry[2]]
        if not found and (number := re.fullmatch(r"number (\d+)", entry[2])):
            found = list(scene.of_table(entry[1])[int(number[1]) :][:1])
        if not found:
            return None
        section = found[-1].section  # of two with one name, the second is wrong
        keys = ((entry[3] or "").partition(".")[0], *(("rpy", "poses") if entry[3] == "pose" else ()))
        return next((item.start for name in keys if (item := section.item(name)) is not None), section.heading)
    if table is not None:
        single = scene.section(table[1])
        item = single.item(table[2].partition(".")[0]) if single is not None else None
        return item.start if item is not None else single.heading if single is not None else None
    if key is not None:
        name = key[1] or key[2]
        item = scene.sections[0].item(name)
        headings = (section.heading for section in scene.sections if section.path[:1] == (name,))
        return item.start if item is not None else next(headings, 0)
    return None


def _asset_line(text: str, error: RlbenchPinError) -> int | None:
    """Return the line that names a model that is missing or broken, or on whose behalf it is needed."""
    path = str(error.path) if isinstance(error, AssetNotFound | AssetInvalid) else ""
    needed_by = error.needed_by if isinstance(error, AssetNotFound) else ""
    for number, line in enumerate(text.split("\n"), start=1):
        asset = re.match(r"""\s*asset\s*=\s*["'](.*?)["']""", line)
        if asset is not None and (asset[1] == path or path.endswith(asset[1].removeprefix("./")) or asset[1] in needed_by):
            return number
    body = re.search(r"body '(.*?)'", needed_by)
    entries = SceneText(text, Path()).of_table("body") if body is not None else ()
    return next((_line_of(text, entry.section.heading) for entry in entries if body is not None and body[1] in entry.names), None)


def _line_of(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


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
    """Return the names of the elements of a kind."""
    bodies = {body.name for body in spec.body}
    match kind:
        case "body":
            return {*bodies, *ROOM}
        case "graspable":
            return bodies
        case "joint":
            limits = ((body.name, read_urdf(resolve_asset(spec, body.asset)).joint_limits) for body in spec.body)
            return {f"{body}/{joint}" for body, joints in limits for joint in joints}
        case "frame":
            return {"root", *(item.name for item in (*spec.frame, *spec.region, *spec.sensor, *spec.waypoint))}
    return {item.name for item in (spec.region if kind == "region" else spec.sensor)}
