"""Reader of TOML scene files: parsing to a frozen `SceneSpec`, short forms of format 2, and checks between tables."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import AssetNotFound, SceneFileError, nearest_name
from rlbench_pin.scene.snapshot import ROOM
from rlbench_pin.scene.spec import (
    FORMAT,
    ROOT,
    TURN,
    WORLD,
    BodySpec,
    PlacementSpec,
    Pose,
    PosedSpec,
    SceneSpec,
    SensorSpec,
    WaypointSpec,
    dotted,
    first_finding,
    is_number,
    key_hint,
)
from rlbench_pin.spatial import TABLE_HEIGHT, above_table, euler_to_quaternion
from rlbench_pin.urdf import Urdf, read_urdf
from rlbench_pin.values import as_path, as_text


def resolve_asset(source: SceneSpec | Path | str, asset: str) -> Path:
    """Return the file of an asset: in `assets/`, or next to the scene file if `asset` starts with `./`.

    Args:
        source: The scene that names the asset, or the path of its file.
        asset: As written in the scene, such as `objects/cube/cube.urdf`.
    """
    if not as_text(asset, "asset").startswith(("./", "../")):
        return asset_path(asset)
    file = source.file if isinstance(source, SceneSpec) else source
    return (as_path(file, "source").parent / asset).resolve()


RESERVED = frozenset({ROOT, WORLD, "robot", *ROOM})
"""Names that the world itself uses."""
SENSOR_SIZES = {"box": ("x", "y", "z"), "cylinder": ("diameter", "length"), "sphere": ("diameter",)}


def check_scene(spec: SceneSpec) -> None:
    """Check one scene as a whole.

    Raises:
        SceneFileError: A key is wrong; the message names table and key.
        AssetNotFound: A URDF, mesh or texture does not exist.
    """
    _check_names(spec)
    models = {body.name: _check_assets(spec, body) for body in spec.body}
    _check_parents(spec, models)
    _check_cycles(spec)
    _check_joints(spec, models)
    for sensor in spec.sensor:
        _check_sensor(spec, sensor)
    _check_waypoints(spec)
    _check_bounds(spec)
    for table in ("excluded_factor", "deviation"):
        _check_described_once(spec, table)
    _check_history(spec)


def table_of(item: PosedSpec) -> str:
    """Return the heading of the table of a record: `[[body]]`, `[[frame]]`, ..."""
    return f"[[{type(item).__name__.removesuffix('Spec').lower()}]]"


def _error(spec: SceneSpec, item: PosedSpec, key: str, problem: str, hint: str = "") -> SceneFileError:
    return SceneFileError(spec.file, f"{table_of(item)} '{item.name}', key '{key}'", problem, hint)


def _guess(name: str, known: Collection[str]) -> str:
    near = nearest_name(name, known)
    return f"Did you mean '{near}'?" if near else f"Known: {', '.join(sorted(known)) or 'none'}."


def _check_names(spec: SceneSpec) -> None:
    seen: dict[str, PosedSpec] = {}
    for item in spec.posed():
        if item.name in RESERVED:
            raise _error(spec, item, "name", f"'{item.name}' is reserved for the room.", "Choose another name.")
        if item.name in seen:
            other = table_of(seen[item.name])
            raise _error(spec, item, "name", f"'{item.name}' is used twice, first in {other}.", "Rename one of them.")
        seen[item.name] = item


def _check_assets(spec: SceneSpec, body: BodySpec) -> Urdf:
    for asset in body.look_alikes:
        _check_asset(spec, body, asset)
    return _check_asset(spec, body, body.asset)


def _check_asset(spec: SceneSpec, body: BodySpec, asset: str) -> Urdf:
    path = resolve_asset(spec, asset)
    needed_by = f"body '{body.name}' of {Path(spec.file).name}"
    if not _is_file(path):
        raise AssetNotFound(asset, needed_by)
    urdf = read_urdf(path, needed_by)
    for file in (*urdf.meshes, *urdf.textures):
        if not _is_file(file):
            raise AssetNotFound(file, f"{asset}, {needed_by}")
    return urdf


def _is_file(path: Path) -> bool:
    """Whether a file exists; False for a name that is not a valid file name."""
    try:
        return path.is_file()
    except OSError:
        return False


def _check_parents(spec: SceneSpec, models: dict[str, Urdf]) -> None:
    names = {item.name for item in spec.posed()} | {ROOT, WORLD}
    for item in spec.posed():
        owner, _, link = item.parent.partition("/")
        if owner not in names:
            raise _error(spec, item, "parent", f"there is no '{owner}' in this scene.", _guess(owner, names))
        if not link:
            continue
        if owner not in models:
            raise _error(spec, item, "parent", f"'{owner}' is not a body and has no link '{link}'.", f"Write '{owner}' alone.")
        links = models[owner].link_names
        if link not in links:
            raise _error(spec, item, "parent", f"body '{owner}' has no link '{link}'.", _guess(link, links))


def _check_cycles(spec: SceneSpec) -> None:
    parents = {item.name: item.parent.partition("/")[0] for item in spec.posed()}
    for item in spec.posed():
        chain = [item.name]
        while (parent := parents.get(chain[-1])) is not None:
            if parent in chain:
                loop = " -> ".join([*chain[chain.index(parent) :], parent])
                raise _error(spec, item, "parent", f"the parents form a cycle: {loop}.", "Give one of them another parent.")
            chain.append(parent)


def _check_joints(spec: SceneSpec, models: dict[str, Urdf]) -> None:
    seen: set[str] = set()
    for joint in spec.joint:
        where = f"[[joint]] '{joint.name}'"
        body, _, name = joint.name.partition("/")
        if body not in models:
            raise SceneFileError(spec.file, where, f"there is no body '{body}'.", _guess(body, models))
        limits = models[body].joint_limits
        if name not in limits:
            hint = _guess(name, limits)
            raise SceneFileError(spec.file, where, f"body '{body}' has no movable joint '{name}'.", hint)
        if joint.name in seen:
            raise SceneFileError(spec.file, where, "it is described twice.", "Remove one of the entries.")
        seen.add(joint.name)
        lower, upper = limits[name]
        if not lower - 1e-9 <= joint.position <= upper + 1e-9:
            problem = f"{joint.position} is outside [{lower}, {upper}]."
            raise SceneFileError(spec.file, f"{where}, key 'position'", problem, "Choose a position in the joint limits.")


def _check_sensor(spec: SceneSpec, sensor: SensorSpec) -> None:
    meaning = SENSOR_SIZES[sensor.shape]
    if len(sensor.size) != len(meaning):
        problem = f"a {sensor.shape} has {len(meaning)} numbers ({', '.join(meaning)}), not {len(sensor.size)}."
        raise _error(spec, sensor, "size", problem, "Write the sizes in this order.")


def _check_waypoints(spec: SceneSpec) -> None:
    expected = [f"waypoint{i}" for i in range(len(spec.waypoint))]
    present = {waypoint.name for waypoint in spec.waypoint}
    for waypoint in spec.waypoint:
        digits = waypoint.name.removeprefix("waypoint")
        if not waypoint.name.startswith("waypoint") or digits != str(int(digits) if digits.isdigit() else -1):
            problem = "the name of a waypoint is 'waypoint' and its number."
            raise _error(spec, waypoint, "name", problem, "Use a [[frame]] for other poses.")
    missing = [name for name in expected if name not in present]
    if missing:
        raise SceneFileError(spec.file, "[[waypoint]]", f"'{missing[0]}' is missing.", "Number waypoints from 0 without gaps.")
    for waypoint in spec.waypoint:
        _check_curve(spec, waypoint)


def _check_curve(spec: SceneSpec, waypoint: WaypointSpec) -> None:
    described = int(bool(waypoint.points)) + int(waypoint.arc is not None)
    if waypoint.path == "curve" and described != 1:
        raise _error(spec, waypoint, "path", "a curve needs either 'points' or 'arc'.", "Give one of them.")
    if waypoint.path != "curve" and described:
        raise _error(spec, waypoint, "path", "'points' and 'arc' belong to a curve.", 'Write path = "curve".')
    if waypoint.compliant and waypoint.path == "curve":
        raise _error(
            spec, waypoint, "compliant", "a compliant approach is a straight line.", "Leave out 'path', 'points' and 'arc'."
        )


def _check_bounds(spec: SceneSpec) -> None:
    low, high = spec.placement.yaw
    if low > high:
        problem = f"the lower bound {low} is above the upper bound {high}."
        raise SceneFileError(spec.file, "[placement], key 'yaw'", problem, "Exchange the two.")


def _check_described_once(spec: SceneSpec, table: str) -> None:
    names = [entry.name for entry in getattr(spec, table)]
    for name in names:
        if names.count(name) > 1:
            raise SceneFileError(spec.file, f"[[{table}]] '{name}'", "it is described twice.", "Remove one of the entries.")


def _check_history(spec: SceneSpec) -> None:
    for expected, entry in enumerate(spec.history, start=2):
        if entry.version != expected:
            problem = f"version {entry.version} is in the place of version {expected}."
            raise SceneFileError(spec.file, "[[history]], key 'version'", problem, "Number the entries 2, 3, ... in their order.")


Entry = dict[str, Any]
ARRAY_TABLES = ("body", "frame", "region", "sensor")
"""Tables whose entries may be arrays."""
POSED_TABLES = (*ARRAY_TABLES, "waypoint")
"""Tables whose entries have a pose."""
SHORT_KEYS = {
    "rpy": "`[roll, pitch, yaw]` of a pose `[x, y, z]`: turns about the fixed x, then y, then z axis.",
    "poses": "Instead of `pose`: one element for each pose; the numbers of their names count on from that of `name`.",
}
"""Keys that replace others, and their meanings."""
_NUMBERED = re.compile(r"(.*\D)(0|[1-9][0-9]{0,8})")
_QUATERNION_DIGITS = 7
_HEIGHT_DIGITS = 12


class TablePlacement(PlacementSpec):
    """A placement whose height counts from the table top."""

    pose: Pose = (*PlacementSpec().pose[:2], 0.0, *PlacementSpec().pose[3:])


class ShortFormError(ValueError):
    """A short form cannot be expanded; the attributes are the wrong key and the cause."""

    def __init__(self, key: str, problem: str, hint: str = "") -> None:
        self.key, self.problem, self.hint = key, problem, hint
        super().__init__(f"key '{key}': {problem} {hint}")


def short_keys(table: str) -> frozenset[str]:
    """Return the additional keys that entries of a table may have in a file of format 2."""
    arrays = {"poses"} if table in ARRAY_TABLES else set()
    return frozenset({"rpy", *arrays} if table in POSED_TABLES else ())


def write_out(table: str, entry: Entry) -> list[Entry]:
    """Expand one entry of a table to one entry per object, with plain poses.

    Args:
        table: Name of the table, such as `body`.
        entry: Its keys as in the file.

    Raises:
        ShortFormError: `rpy` or `poses` is invalid.
    """
    keys = short_keys(table)
    entries = _array(entry) if "poses" in keys & entry.keys() else [entry]
    return [_turned(item) for item in entries] if "rpy" in keys & entry.keys() else entries


def placement_from_file(placement: PlacementSpec) -> PlacementSpec:
    """Return a placement in the world, of one whose height counts from the table top."""
    if "pose" not in placement.model_fields_set:
        return placement
    x, y, z, *quaternion = placement.pose
    return placement.model_copy(update={"pose": (x, y, above_table(z), *quaternion)})


def placement_for_file(placement: PlacementSpec) -> TablePlacement:
    """Return a placement for a file of format 2, whose height counts from the table top."""
    x, y, z, *quaternion = placement.pose
    pose = (x, y, round(z - TABLE_HEIGHT, _HEIGHT_DIGITS), *quaternion)
    return TablePlacement.model_validate({**placement.model_dump(), "pose": pose})


def _array(entry: Entry) -> list[Entry]:
    """Return one entry for each of `poses`, with numbered names: `piece0`, `piece1`, ..."""
    poses, name = entry["poses"], entry.get("name")
    if "pose" in entry:
        raise ShortFormError("poses", "an entry has either 'poses' or 'pose'.", "Leave one of them out.")
    if not isinstance(poses, list) or not poses or not all(isinstance(pose, list) for pose in poses):
        raise ShortFormError("poses", "it is a list of poses, one for each element.", "Write poses = [[x, y, z], ...].")
    numbered = _NUMBERED.fullmatch(name) if isinstance(name, str) else None
    if numbered is None:
        problem = f"the first name of an array ends with a number without leading zeros, not {name!r}."
        raise ShortFormError("name", problem, "Use a numbered name such as 'piece0'.")
    stem, first = numbered[1], int(numbered[2])
    rest = {key: value for key, value in entry.items() if key not in ("poses", "name")}
    return [{"name": f"{stem}{first + k}", **rest, "pose": pose} for k, pose in enumerate(poses)]


def _turned(entry: Entry) -> Entry:
    """Replace `rpy` by a quaternion, rounded to 1e-7, so that angles with seven digits give exact right angles."""
    rpy, pose = entry["rpy"], entry.get("pose", [0.0, 0.0, 0.0])
    if not isinstance(rpy, list) or len(rpy) != 3 or not all(is_number(angle) for angle in rpy):
        raise ShortFormError("rpy", f"it has three angles in [rad], not {rpy!r}.", "Write [roll, pitch, yaw].")
    if max(abs(angle) for angle in rpy) > TURN:
        raise ShortFormError("rpy", f"angles are at most 2 pi = 6.2832 rad, not {rpy!r}.", "Are these degrees?")
    if not isinstance(pose, list) or len(pose) != 3:
        raise ShortFormError("rpy", "it needs a pose [x, y, z].", "Leave the rotation out of the pose.")
    quaternion = [round(float(v), _QUATERNION_DIGITS) + 0.0 for v in euler_to_quaternion(*rpy)]
    rest = {key: value for key, value in entry.items() if key not in ("rpy", "pose")}
    return {**rest, "pose": [*pose, *quaternion]}


Raw = dict[str, Any]
_OWN = ("deviation", "history")
"""Tables that a scene does not take from its base."""


def read_scene(path: Path | str) -> SceneSpec:
    """Read and check one scene file.

    Args:
        path: The `.toml` file.

    Raises:
        SceneFileError: The file is invalid; the message names the table, the key and the nearest known word.
        AssetNotFound: A URDF, mesh or texture that the scene needs does not exist.
        AssetInvalid: A URDF is not XML.
    """
    path = as_path(path, "path")
    return scene_from_raw(_parse(path), path)


def read_scene_text(text: str, path: Path | str) -> SceneSpec:
    """Read and check the text of a scene file, which need not exist on disk.

    Args:
        text: Content of the file.
        path: Path of the file, present or future; assets with `./` are searched next to it.

    Raises:
        SceneFileError: The text is invalid; the message names the table, the key and the nearest known word.
        AssetNotFound: A URDF, mesh or texture that the scene needs does not exist.
        AssetInvalid: A URDF is not XML.
    """
    path = as_path(path, "path")
    return scene_from_raw(raw_scene(text, path), path)


def raw_scene(text: str, path: Path | str) -> Raw:
    """Return the tables of a scene file as written; only the TOML syntax is checked.

    Raises:
        SceneFileError: It is not valid TOML.
    """
    try:
        return tomllib.loads(as_text(text, "text"))
    except (ValueError, RecursionError) as error:  # invalid TOML or UTF-8, too deep, or a number of too many digits
        raise SceneFileError(as_path(path, "path"), "file", f"it is not valid TOML: {error}.", "Correct the text.") from error


def scene_from_raw(raw: Raw, path: Path) -> SceneSpec:
    """Check tables from `raw_scene`, and return the scene."""
    _check_format(path, raw)
    if "departure" in raw and "deviation" not in raw:  # the name of the table in older files
        raw = {"deviation" if table == "departure" else table: content for table, content in raw.items()}
    if raw["format"] == FORMAT:
        raw = _written_out(path, raw)
    if "base" in raw:
        raw = _with_base(path, raw)
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
        raise SceneFileError(path, "file", f"'{path}' does not exist.", f"Did you mean '{near}'?" if near else "Check the path.")
    try:
        text = path.read_text(encoding="utf-8")
    except ValueError as error:
        raise SceneFileError(path, "file", f"it is not valid TOML: {error}.", "Correct the text.") from error
    except OSError as error:
        raise SceneFileError(path, "file", f"it cannot be read: {error.strerror}.", "Check its permissions.") from error
    return raw_scene(text, path)


def _check_format(path: Path, raw: Raw) -> None:
    if "format" not in raw:
        raise SceneFileError(path, "key 'format'", "it is missing.", f"Begin the file with `format = {FORMAT}`.")
    if isinstance(raw["format"], bool | float) or raw["format"] not in range(1, FORMAT + 1):
        hint = f"This version reads the formats 1 to {FORMAT}."
        raise SceneFileError(path, "key 'format'", f"{raw['format']!r} is not supported.", hint)


def _with_base(path: Path, raw: Raw) -> Raw:
    """Return the tables of a scene merged over those of its base; deviations and history are not inherited."""
    known, name = {file.stem for file in path.parent.glob("*.toml")} - {path.stem}, str(raw["base"])
    if name not in known:
        raise SceneFileError(path, "key 'base'", f"there is no scene '{name}' in the same folder.", _guess(name, known))
    file = path.with_name(f"{name}.toml")
    base = _parse(file)
    _check_format(file, base)
    if "base" in base or base["format"] != raw["format"]:
        raise SceneFileError(path, "key 'base'", f"'{file.name}' has a base itself, or another format.", "Name another scene.")
    if base["format"] == FORMAT:
        base = _written_out(file, base)
    own = {table: _merged(table, base.get(table), content) for table, content in raw.items()}
    return {**base, **{table: [] for table in _OWN}, **own}


def _merged(table: str, base: Any, own: Any) -> Any:
    """Return one table merged over that of the base: the keys of `[placement]`, or entries by name."""
    if isinstance(base, dict) and isinstance(own, dict):
        return {**base, **own}
    if table in _OWN or not all(isinstance(part, list) and all(isinstance(e, dict) for e in part) for part in (base, own)):
        return own
    named = {str(entry.get("name")): entry for entry in own}
    kept = [named.pop(str(entry.get("name")), entry) for entry in base]
    return [*kept, *(entry for entry in own if str(entry.get("name")) in named)]


def _written_out(path: Path, raw: Raw) -> Raw:
    """Return the content of a file with the short forms of format 2 expanded."""
    return {table: _entries(path, table, content) if table in POSED_TABLES else content for table, content in raw.items()}


def _entries(path: Path, table: str, content: Any) -> Any:
    """Expand one array of tables; later checks refuse content of another kind."""
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
    """Convert a validation error of pydantic to a SceneFileError."""
    found = first_finding(error)
    hint = _known_keys(raw, found.location) if found.kind == "unknown" else ""
    return SceneFileError(path, _where(raw, found.location), found.problem, hint)


def _known_keys(raw: Raw, location: tuple[int | str, ...]) -> str:
    """Return a hint with the allowed keys for an unknown one."""
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
    """Return the known keys at a place of the file."""
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
