"""What a scene file of format 2 says in short: `rpy` for a rotation, `poses` for an array, heights from the table top."""

from __future__ import annotations

import re
from typing import Any

from rlbench_pin.scene.kinds import TURN, Pose, is_number
from rlbench_pin.scene.spec import PlacementSpec
from rlbench_pin.spatial import TABLE_HEIGHT, above_table, euler_to_quaternion

Entry = dict[str, Any]
ARRAY_TABLES = ("body", "frame", "region", "sensor")
"""Tables whose entries may be arrays."""
POSED_TABLES = (*ARRAY_TABLES, "waypoint")
"""Tables whose entries have a pose."""
SHORT_KEYS = {
    "rpy": "`[roll, pitch, yaw]` of a pose `[x, y, z]`: turns about the fixed x, then y, then z axis.",
    "poses": "Instead of `pose`: one thing for each pose; the numbers of their names count on from that of `name`.",
}
"""Keys that stand for others, and what they mean."""
_NUMBERED = re.compile(r"(.*\D)(0|[1-9][0-9]{0,8})")
_QUATERNION_DIGITS = 7
_HEIGHT_DIGITS = 12


class TablePlacement(PlacementSpec):
    """A placement whose height counts from the table top."""

    pose: Pose = (*PlacementSpec().pose[:2], 0.0, *PlacementSpec().pose[3:])


class ShortFormError(ValueError):
    """A short form cannot be written out; says which key is wrong and why."""

    def __init__(self, key: str, problem: str, hint: str = "") -> None:
        self.key, self.problem, self.hint = key, problem, hint
        super().__init__(f"key '{key}': {problem} {hint}")


def short_keys(table: str) -> frozenset[str]:
    """Return the keys that entries of a table may have in a file of format 2, beside those of its record."""
    arrays = {"poses"} if table in ARRAY_TABLES else set()
    return frozenset({"rpy", *arrays} if table in POSED_TABLES else ())


def write_out(table: str, entry: Entry) -> list[Entry]:
    """Return what one entry of a table stands for, one entry per thing, with plain poses.

    Args:
        table: Name of the table, such as `body`.
        entry: Its keys as they stand in the file.

    Raises:
        ShortFormError: `rpy` or `poses` is not what it should be.
    """
    keys = short_keys(table)
    entries = _array(entry) if "poses" in keys & entry.keys() else [entry]
    return [_turned(item) for item in entries] if "rpy" in keys & entry.keys() else entries


def placement_from_file(placement: PlacementSpec) -> PlacementSpec:
    """Return a placement whose height counts from the table top as one in the world."""
    if "pose" not in placement.model_fields_set:
        return placement
    x, y, z, *quaternion = placement.pose
    return placement.model_copy(update={"pose": (x, y, above_table(z), *quaternion)})


def placement_for_file(placement: PlacementSpec) -> TablePlacement:
    """Return a placement in the world as a file of format 2 says it."""
    x, y, z, *quaternion = placement.pose
    pose = (x, y, round(z - TABLE_HEIGHT, _HEIGHT_DIGITS), *quaternion)
    return TablePlacement.model_validate({**placement.model_dump(), "pose": pose})


def _array(entry: Entry) -> list[Entry]:
    """Count on from the name of the first: `piece0`, `piece1`, ..., one for each of `poses`."""
    poses, name = entry["poses"], entry.get("name")
    if "pose" in entry:
        raise ShortFormError("poses", "it stands instead of 'pose', not beside it.", "Leave one of them out.")
    if not isinstance(poses, list) or not poses or not all(isinstance(pose, list) for pose in poses):
        raise ShortFormError("poses", "it is a list of poses, one for each thing.", "Write poses = [[x, y, z], ...].")
    numbered = _NUMBERED.fullmatch(name) if isinstance(name, str) else None
    if numbered is None:
        raise ShortFormError("name", f"an array begins with a numbered name, not {name!r}.", "Call the first one 'piece0'.")
    stem, first = numbered[1], int(numbered[2])
    rest = {key: value for key, value in entry.items() if key not in ("poses", "name")}
    return [{"name": f"{stem}{first + k}", **rest, "pose": pose} for k, pose in enumerate(poses)]


def _turned(entry: Entry) -> Entry:
    """Replace `rpy` by a quaternion, rounded to 1e-7: angles with seven digits suffice for exact right angles."""
    rpy, pose = entry["rpy"], entry.get("pose", [0.0, 0.0, 0.0])
    if not isinstance(rpy, list) or len(rpy) != 3 or not all(is_number(angle) for angle in rpy):
        raise ShortFormError("rpy", f"it is [roll, pitch, yaw], three angles in [rad], not {rpy!r}.")
    if max(abs(angle) for angle in rpy) > TURN:
        raise ShortFormError("rpy", f"angles are at most one turn, 2 pi = 6.2832 rad, not {rpy!r}.", "Were these degrees?")
    if not isinstance(pose, list) or len(pose) != 3:
        raise ShortFormError("rpy", "it goes with a pose [x, y, z].", "Leave the rotation out of the pose.")
    quaternion = [round(float(v), _QUATERNION_DIGITS) + 0.0 for v in euler_to_quaternion(*rpy)]
    rest = {key: value for key, value in entry.items() if key not in ("rpy", "pose")}
    return {**rest, "pose": [*pose, *quaternion]}
