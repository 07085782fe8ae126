"""TOML scene file -> frozen `SceneSpec`, or an error that says which file, which table, which key."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from rlbench_pin.errors import SceneFileError, nearest_name
from rlbench_pin.scene.checks import check_scene
from rlbench_pin.scene.findings import dotted, first_finding, key_hint
from rlbench_pin.scene.short_forms import POSED_TABLES, ShortFormError, placement_from_file, short_keys, write_out
from rlbench_pin.scene.spec import FORMAT, SceneSpec
from rlbench_pin.values import as_path, as_text

Raw = dict[str, Any]


def read_scene(path: Path | str) -> SceneSpec:
    """Read and check one scene file.

    Args:
        path: The `.toml` file.

    Raises:
        SceneFileError: Something in the file is wrong; names the table, the key and the nearest known word.
        AssetNotFound: A URDF, mesh or texture that the scene needs does not exist.
        AssetInvalid: A URDF is not XML.
    """
    path = as_path(path, "path")
    return scene_from_raw(_parse(path), path)


def read_scene_text(text: str, path: Path | str) -> SceneSpec:
    """Read and check the content of a scene file that may not have been written yet.

    Args:
        text: What the file says.
        path: Where the file lies, or will lie: models of its own are found from here.

    Raises:
        SceneFileError: Something in the text is wrong; names the table, the key and the nearest known word.
        AssetNotFound: A URDF, mesh or texture that the scene needs does not exist.
        AssetInvalid: A URDF is not XML.
    """
    path = as_path(path, "path")
    return scene_from_raw(raw_scene(text, path), path)


def raw_scene(text: str, path: Path | str) -> Raw:
    """Return the tables of a scene file as they stand in its text; nothing but the TOML is checked.

    Raises:
        SceneFileError: It is not valid TOML.
    """
    try:
        return tomllib.loads(as_text(text, "text"))
    except (ValueError, RecursionError) as error:  # what is no TOML, no UTF-8, too deep, or a number of too many digits
        raise SceneFileError(as_path(path, "path"), "file", f"it is not valid TOML: {error}.") from error


def scene_from_raw(raw: Raw, path: Path) -> SceneSpec:
    """Check the tables of a scene file, which `raw_scene` returned, and return the scene."""
    _check_format(path, raw)
    if "departure" in raw and "deviation" not in raw:  # the name of the table in older files
        raw = {"deviation" if table == "departure" else table: content for table, content in raw.items()}
    if raw["format"] == FORMAT:
        raw = _written_out(path, raw)
    try:
        scene = SceneSpec.model_validate({**raw, "file": str(path)})
    except ValidationError as error:
        raise _scene_file_error(path, raw, error) from error
    if scene.format == FORMAT:
        scene = scene.model_copy(update={"placement": placement_from_file(scene.placement)})
    check_scene(scene)
    return scene


def _parse(path: Path) -> Raw:
    if not path.is_file():
        siblings = [p.name for p in path.parent.glob("*.toml")] if path.parent.is_dir() else []
        near = nearest_name(path.name, siblings)
        raise SceneFileError(path, "file", f"'{path}' does not exist.", f"Did you mean '{near}'?" if near else "")
    try:
        text = path.read_text(encoding="utf-8")
    except ValueError as error:
        raise SceneFileError(path, "file", f"it is not valid TOML: {error}.") from error
    except OSError as error:
        raise SceneFileError(path, "file", f"it cannot be read: {error.strerror}.", "See who may read it.") from error
    return raw_scene(text, path)


def _check_format(path: Path, raw: Raw) -> None:
    if "format" not in raw:
        raise SceneFileError(path, "key 'format'", "it is missing.", f"Begin the file with `format = {FORMAT}`.")
    if isinstance(raw["format"], bool | float) or raw["format"] not in range(1, FORMAT + 1):
        hint = f"This version reads the formats 1 to {FORMAT}."
        raise SceneFileError(path, "key 'format'", f"{raw['format']!r} is not supported.", hint)


def _written_out(path: Path, raw: Raw) -> Raw:
    """Return the content of a file with the short forms of format 2 written out."""
    return {table: _entries(path, table, content) if table in POSED_TABLES else content for table, content in raw.items()}


def _entries(path: Path, table: str, content: Any) -> Any:
    """Write out one array of tables; content of another kind is left to the checks that follow."""
    if not isinstance(content, list) or not all(isinstance(entry, dict) for entry in content):
        return content
    entries: list[Raw] = []
    for number, entry in enumerate(content):
        try:
            entries += write_out(table, entry)
        except ShortFormError as error:
            where = f"{_entry_name(table, number, entry)}, key '{error.key}'"
            raise SceneFileError(path, where, error.problem, error.hint) from error
    return entries


def _scene_file_error(path: Path, raw: Raw, error: ValidationError) -> SceneFileError:
    """Turn one validation error of pydantic into ours."""
    found = first_finding(error)
    hint = _known_keys(raw, found.location) if found.kind == "unknown" else ""
    return SceneFileError(path, _where(raw, found.location), found.problem, hint)


def _known_keys(raw: Raw, location: tuple[int | str, ...]) -> str:
    """Say which keys are allowed in the place of an unknown one."""
    known = _fields_at(location[:-1]) - {"file"}
    short = short_keys(str(location[0])) if len(location) == 3 else frozenset()
    if raw["format"] < FORMAT and location[-1] in short:
        return f"It is known from `format = {FORMAT}` on."
    return key_hint(str(location[-1]), known | short if raw["format"] == FORMAT else known)


def _where(raw: Raw, location: tuple[int | str, ...]) -> str:
    """Write `("waypoint", 2, "path")` as `[[waypoint]] 'waypoint2', key 'path'`."""
    if not location:
        return "file"
    table, rest = location[0], location[1:]
    if not rest:
        return f"key '{table}'"
    if not isinstance(rest[0], int):
        return f"[{table}], key '{dotted(rest)}'"
    key = f", key '{dotted(rest[1:])}'" if rest[1:] else ""
    return f"{_entry_name(str(table), rest[0], raw[str(table)][rest[0]])}{key}"


def _entry_name(table: str, number: int, entry: Any) -> str:
    name = entry.get("name", f"number {number}") if isinstance(entry, dict) else f"number {number}"
    return f"[[{table}]] '{name}'"


def _fields_at(location: tuple[int | str, ...]) -> set[str]:
    """Return the keys that are known at a place of the file."""
    model: type[BaseModel] = SceneSpec
    for part in location:
        if isinstance(part, str) and part in model.model_fields:
            model = _model_in(model.model_fields[part].annotation) or model
    return set(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """Find the record inside annotations such as `tuple[BodySpec, ...]` or `ArcSpec | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_model_in(argument) for argument in get_args(annotation))
    return next((model for model in found if model is not None), None)
