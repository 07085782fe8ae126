"""TOML scene file -> frozen `SceneSpec`, or an error that says which file, which table, which key."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from rlbench_pin.errors import SceneFileError, nearest_name
from rlbench_pin.scene.checks import check_scene
from rlbench_pin.scene.spec import FORMAT, SceneSpec

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
    path = Path(path)
    raw = _parse(path)
    _check_format(path, raw)
    try:
        scene = SceneSpec.model_validate({**raw, "file": str(path)})
    except ValidationError as error:
        raise _scene_file_error(path, raw, error) from error
    check_scene(scene)
    return scene


def _parse(path: Path) -> Raw:
    if not path.is_file():
        siblings = [p.name for p in path.parent.glob("*.toml")] if path.parent.is_dir() else []
        near = nearest_name(path.name, siblings)
        raise SceneFileError(path, "file", f"'{path}' does not exist.", f"Did you mean '{near}'?" if near else "")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SceneFileError(path, "file", f"it is not valid TOML: {error}.") from error


def _check_format(path: Path, raw: Raw) -> None:
    if "format" not in raw:
        raise SceneFileError(path, "key 'format'", "it is missing.", f"Begin the file with `format = {FORMAT}`.")
    if raw["format"] != FORMAT:
        raise SceneFileError(path, "key 'format'", f"{raw['format']!r} is not supported.", f"This version reads format {FORMAT}.")


def _scene_file_error(path: Path, raw: Raw, error: ValidationError) -> SceneFileError:
    """Turn one finding of pydantic into our words; a misspelt key explains a missing one, so it comes first."""
    findings = error.errors(include_url=False)
    first = next((f for f in findings if f["type"] == "extra_forbidden"), findings[0])
    location = tuple(part for part in first["loc"] if part not in ("float", "int", "str", "literal"))
    where = _where(raw, location)
    if first["type"] == "extra_forbidden":
        known = sorted(_fields_at(location[:-1]) - {"file"})
        near = nearest_name(str(location[-1]), known)
        hint = f"Did you mean '{near}'?" if near else f"Known keys: {', '.join(known)}."
        return SceneFileError(path, where, f"'{location[-1]}' is not known here.", hint)
    if first["type"] == "missing":
        return SceneFileError(path, where, f"the key '{location[-1]}' is missing.")
    message = first["msg"].removeprefix("Value error, ")
    given = first["input"]
    shown = "" if isinstance(given, dict) else f" (given: {given!r})"
    return SceneFileError(path, where, f"{message}{shown}.")


def _where(raw: Raw, location: tuple[int | str, ...]) -> str:
    """Write `("waypoint", 2, "path")` as `[[waypoint]] 'waypoint2', key 'path'`."""
    if not location:
        return "file"
    table, rest = location[0], location[1:]
    if not rest:
        return f"key '{table}'"
    if not isinstance(rest[0], int):
        return f"[{table}], key '{_dotted(rest)}'"
    entry = raw[str(table)][rest[0]]
    name = entry.get("name", f"number {rest[0]}") if isinstance(entry, dict) else f"number {rest[0]}"
    key = f", key '{_dotted(rest[1:])}'" if rest[1:] else ""
    return f"[[{table}]] '{name}'{key}"


def _dotted(parts: tuple[int | str, ...]) -> str:
    return ".".join(str(part) for part in parts)


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
