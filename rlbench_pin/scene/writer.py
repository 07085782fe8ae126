"""Writer of a `SceneSpec` to a TOML scene file. Unchanged parts of the file keep their text, order and comments."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticUndefined
from tomlkit.items import AoT, InlineTable, Table

from rlbench_pin.errors import InvalidValue, SceneFileError, StorageError
from rlbench_pin.scene.reader import ShortFormError, placement_for_file, read_scene, write_out
from rlbench_pin.scene.spec import (
    FORMAT,
    BodySpec,
    DeviationSpec,
    ExcludedFactorSpec,
    FrameSpec,
    HistorySpec,
    InstructionsSpec,
    JointSpec,
    PlacementSpec,
    RegionSpec,
    SceneSpec,
    SensorSpec,
    Spec,
    WaypointSpec,
)
from rlbench_pin.values import as_path, as_record

HEADER = "lengths [m], angles [rad], pose [x, y, z] or [x, y, z, yaw] or [x, y, z, qx, qy, qz, qw], or [x, y, z] and rpy"
TABLES: Mapping[str, type[Spec]] = {
    "body": BodySpec,
    "joint": JointSpec,
    "frame": FrameSpec,
    "region": RegionSpec,
    "sensor": SensorSpec,
    "waypoint": WaypointSpec,
    "excluded_factor": ExcludedFactorSpec,
    "deviation": DeviationSpec,
}
"""Table -> what its entries are."""
_TABLE_OF = {model: table for table, model in TABLES.items()}
_POSES = frozenset({"pose", "points"})
_DIGITS = 9
_HEADING = re.compile(r"^(?!#)(.+)\n(\[{1,2}[a-z_]+\]{1,2} *(?:#.*)?)$", re.MULTILINE)
"""A line that is not a comment, and right below it the heading of a table."""


def write_scene(spec: SceneSpec, path: Path | str) -> None:
    """Write a scene to a file.

    An existing file is edited in place and keeps its format: entries are matched by name, and only changed keys are written.
    An array stays an array if none of its elements has changed; otherwise each element gets an entry. A new file has format 2.
    Numbers are rounded to 1e-9. A file with a `base` does not change.

    Args:
        spec: The scene.
        path: The `.toml` file; its folder must exist.

    Raises:
        InvalidValue: `path` is not the path of a file.
        SceneFileError: The existing file is not TOML, or has a `base` and another content; it does not change.
        StorageError: The file cannot be written, or the existing one cannot be read. No temporary file is left.
    """
    path, spec = as_path(path, "path"), as_record(spec, SceneSpec, "spec")
    if not path.name:
        raise InvalidValue("path", str(path), "has to name a file")
    document = _document(path) if path.is_file() else _new_document()
    if "base" in document:
        if _alike(read_scene(path).model_copy(update={"file": spec.file, "base": spec.base}), spec):
            return
        raise SceneFileError(path, "key 'base'", "values from the base cannot be changed in this file.", "Write a new file.")
    _write_placement(document, spec.placement)
    _write_instructions(document, spec.instructions)
    for table, model in TABLES.items():
        _write_table(document, table, model, getattr(spec, table))
    _write_table(document, "history", HistorySpec, spec.history, identity="version")
    _replace(path, _HEADING.sub(r"\1\n\n\2", tomlkit.dumps(document)))


def _document(path: Path) -> tomlkit.TOMLDocument:
    """Return the content of a file, with its comments."""
    try:
        return tomlkit.parse(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StorageError(path, error) from error
    except (ValueError, RecursionError) as error:
        hint = "Mend it, delete it, or choose another file."
        raise SceneFileError(path, "file", f"it is not valid TOML: {error}.", hint) from error


def _replace(path: Path, text: str) -> None:
    """Write a file atomically."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except OSError as error:
        raise StorageError(path, error) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _new_document() -> tomlkit.TOMLDocument:
    document = tomlkit.document()
    document.add("format", tomlkit.item(FORMAT).comment(HEADER))
    return document


def _write_placement(document: tomlkit.TOMLDocument, placement: PlacementSpec) -> None:
    if placement == PlacementSpec() and "placement" not in document:
        return
    if document["format"] == FORMAT:
        placement = placement_for_file(placement)
    if "placement" not in document:
        document.add(tomlkit.nl())
        document.add("placement", tomlkit.table())
    _update(document["placement"], placement)


def _write_instructions(document: tomlkit.TOMLDocument, instructions: InstructionsSpec) -> None:
    if instructions == InstructionsSpec():
        document.pop("instructions", None)
        return
    if "instructions" not in document:
        document.add(tomlkit.nl())
        document.add("instructions", tomlkit.table())
    _update(document["instructions"], instructions)


def _write_table(
    document: tomlkit.TOMLDocument, key: str, model: type[Spec], specs: Iterable[Any], identity: str = "name"
) -> None:
    """Write `specs` to the array of tables `[[key]]`, in their order; entries are matched by the key `identity`."""
    wanted = {getattr(spec, identity): spec for spec in specs}
    present = document.get(key)
    if not isinstance(present, AoT):
        if not wanted:
            return
        present = tomlkit.aot()
        document.add(key, present)
    kept = _keep_arrays(present, model, wanted)
    for index in reversed(range(len(present))):
        if present[index].get(identity) not in wanted:
            del present[index]
    known = {entry[identity]: entry for entry in present}
    for name, spec in wanted.items():
        if name in kept:
            continue
        if name not in known:
            present.append(_new_entry(after=present))
        _update(known.get(name, present[-1]), spec)
    if not wanted:
        del document[key]


def _keep_arrays(present: AoT, model: type[Spec], wanted: Mapping[str, Any]) -> set[str]:
    """Expand the arrays of a table that have changed, and return the names of all elements of the other arrays."""
    kept: set[str] = set()
    for index in reversed(range(len(present))):
        if "poses" not in present[index]:
            continue
        items = {item.name: item for item in _parsed(present[index], model)}
        if items and all(name in wanted and _alike(item, wanted[name]) for name, item in items.items()):
            kept |= items.keys()
            continue
        del present[index]
        for k, name in enumerate(name for name in items if name in wanted):
            entry = tomlkit.table()
            entry["name"] = name
            present.insert(index + k, entry)
    return kept


def _alike(a: Spec, b: Spec) -> bool:
    return all(_same(getattr(a, key), getattr(b, key)) for key in type(a).model_fields)


def _new_entry(after: AoT) -> Table:
    """Begin an entry after one blank line."""
    entry = tomlkit.table()
    if not after.as_string().endswith("\n\n"):
        entry.trivia.indent = "\n"
    return entry


def _update(entry: Any, spec: Spec) -> None:
    """Change the keys of one table whose value differs from `spec`; keys at their default are left out."""
    before = next(iter(_parsed(entry, type(spec))), None)
    for key, info in type(spec).model_fields.items():
        value = getattr(spec, key)
        present = key in entry or (key == "pose" and "rpy" in entry)
        if before is not None and present and _same(getattr(before, key), value):
            continue
        if key == "pose":
            entry.pop("rpy", None)
        is_default = info.default is not PydanticUndefined and _same(value, info.default)
        if is_default or value is None:
            entry.pop(key, None)
        else:
            entry[key] = _plain(key, value)


def _parsed(entry: Any, model: type[Any]) -> list[Any]:
    """Return the elements of one table of the file; none when it is new or not valid."""
    try:
        return [model.model_validate(plain) for plain in write_out(_TABLE_OF.get(model, "placement"), entry.unwrap())]
    except (ValidationError, ShortFormError):
        return []


def _same(a: Any, b: Any) -> bool:
    """Compare values; numbers to 1e-9."""
    if isinstance(a, bool | str) or isinstance(b, bool | str) or a is None or b is None:
        return type(a) is type(b) and bool(a == b)
    if isinstance(a, int | float) and isinstance(b, int | float):
        return abs(a - b) < 10.0**-_DIGITS
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def _plain(key: str, value: Any) -> Any:
    """Convert a value to its form in TOML: short poses, rounded numbers, inline tables."""
    if isinstance(value, BaseModel):
        return _inline(value)
    if key in _POSES and value and isinstance(value[0], tuple):
        return [_short_pose(pose) for pose in value]
    if key in _POSES and value:
        return _short_pose(value)
    if isinstance(value, tuple | list):
        return [_plain("", item) for item in value]
    return _rounded(value) if isinstance(value, float) else value


def _inline(record: BaseModel) -> InlineTable:
    table = tomlkit.inline_table()
    for key, info in type(record).model_fields.items():
        value = getattr(record, key)
        if value is not None and (info.default is PydanticUndefined or not _same(value, info.default)):
            table[key] = _plain(key, value)
    return table


def _short_pose(pose: tuple[float, ...]) -> list[float]:
    """Leave out an identity rotation; write a rotation about z as its angle."""
    numbers = [_rounded(v) for v in pose]
    if any(numbers[3:5]):
        return numbers
    yaw = 2.0 * float(np.arctan2(pose[5], pose[6]))
    return numbers[:3] if abs(yaw) < 10.0**-_DIGITS else [*numbers[:3], _rounded(yaw)]


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS) + 0.0
