"""What must hold between the tables of one scene: names, parents, assets, joints, waypoints."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from rlbench_pin.errors import AssetNotFound, SceneFileError, nearest_name
from rlbench_pin.scene.model_files import resolve_asset
from rlbench_pin.scene.snapshot import ROOM
from rlbench_pin.scene.spec import ROOT, WORLD, BodySpec, PosedSpec, SceneSpec, SensorSpec, WaypointSpec
from rlbench_pin.urdf import Urdf, read_urdf

RESERVED = frozenset({ROOT, WORLD, "robot", *ROOM})
"""Names that the world itself uses."""
SENSOR_SIZES = {"box": ("x", "y", "z"), "cylinder": ("diameter", "length"), "sphere": ("diameter",)}


def check_scene(spec: SceneSpec) -> None:
    """Check one scene as a whole.

    Raises:
        SceneFileError: Names the table and the key that are wrong.
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
    _check_deviations(spec)


def table_of(item: PosedSpec) -> str:
    """Return how the table of a record is written in the file: `[[body]]`, `[[frame]]`, ..."""
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
            raise _error(spec, item, "name", f"'{item.name}' is used twice, first in {other}.", "Names are unique in a file.")
        seen[item.name] = item


def _check_assets(spec: SceneSpec, body: BodySpec) -> Urdf:
    path = resolve_asset(spec, body.asset)
    needed_by = f"body '{body.name}' of {Path(spec.file).name}"
    if not _is_file(path):
        raise AssetNotFound(body.asset, needed_by)
    urdf = read_urdf(path, needed_by)
    for file in (*urdf.meshes, *urdf.textures):
        if not _is_file(file):
            raise AssetNotFound(file, f"{body.asset}, {needed_by}")
    return urdf


def _is_file(path: Path) -> bool:
    """Whether there is such a file; a name that no file can have is that of none."""
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
            raise _error(spec, item, "parent", f"'{owner}' is not a body, so it has no link '{link}'.")
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
                raise _error(spec, item, "parent", f"the parents form a circle: {loop}.")
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
            raise SceneFileError(spec.file, where, "it is described twice.")
        seen.add(joint.name)
        lower, upper = limits[name]
        if not lower - 1e-9 <= joint.position <= upper + 1e-9:
            raise SceneFileError(spec.file, f"{where}, key 'position'", f"{joint.position} is outside [{lower}, {upper}].")


def _check_sensor(spec: SceneSpec, sensor: SensorSpec) -> None:
    meaning = SENSOR_SIZES[sensor.shape]
    if len(sensor.size) != len(meaning):
        problem = f"a {sensor.shape} has {len(meaning)} numbers ({', '.join(meaning)}), not {len(sensor.size)}."
        raise _error(spec, sensor, "size", problem)


def _check_waypoints(spec: SceneSpec) -> None:
    expected = [f"waypoint{i}" for i in range(len(spec.waypoint))]
    present = {waypoint.name for waypoint in spec.waypoint}
    for waypoint in spec.waypoint:
        digits = waypoint.name.removeprefix("waypoint")
        if not waypoint.name.startswith("waypoint") or digits != str(int(digits) if digits.isdigit() else -1):
            problem = "a waypoint is called 'waypoint' and its number."
            raise _error(spec, waypoint, "name", problem, "Use a [[frame]] for other places.")
    missing = [name for name in expected if name not in present]
    if missing:
        raise SceneFileError(spec.file, "[[waypoint]]", f"'{missing[0]}' is missing.", "Number waypoints from 0 without gaps.")
    for waypoint in spec.waypoint:
        _check_curve(spec, waypoint)


def _check_curve(spec: SceneSpec, waypoint: WaypointSpec) -> None:
    described = int(bool(waypoint.points)) + int(waypoint.arc is not None)
    if waypoint.path == "curve" and described != 1:
        raise _error(spec, waypoint, "path", "a curve needs either 'points' or 'arc'.")
    if waypoint.path != "curve" and described:
        raise _error(spec, waypoint, "path", "'points' and 'arc' belong to a curve.", 'Write path = "curve".')


def _check_bounds(spec: SceneSpec) -> None:
    low, high = spec.placement.yaw
    if low > high:
        raise SceneFileError(spec.file, "[placement], key 'yaw'", f"the lower bound {low} is above the upper bound {high}.")


def _check_deviations(spec: SceneSpec) -> None:
    names = [deviation.name for deviation in spec.deviation]
    for name in names:
        if names.count(name) > 1:
            raise SceneFileError(spec.file, f"[[deviation]] '{name}'", "it is described twice.")
