"""What a scene file says for the values of forms: short poses, rounded numbers, nothing that is said already or by default."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rlbench_pin.builder.document.scene_text.poses import pose_keys, short_pose
from rlbench_pin.builder.document.scene_text.scene_text import PLACEMENT
from rlbench_pin.builder.document.scene_text.values import is_same, plain
from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.scene.reader import ShortFormError, TablePlacement, write_out
from rlbench_pin.scene.spec import ArcSpec, PlacementSpec, Spec, SpringSpec
from rlbench_pin.scene.writer import TABLES
from rlbench_pin.values import as_several

RECORDS: Mapping[str, type[Spec]] = {PLACEMENT: PlacementSpec, **TABLES}
"""Table -> what its entries are."""
_INNER: Mapping[str, type[Spec]] = {"arc": ArcSpec, "spring": SpringSpec}


def written_keys(table: str, values: Mapping[str, Any], raw: Mapping[str, Any], *, short_forms: bool = True) -> dict[str, Any]:
    """Return what to write so that an entry says other values.

    Args:
        table: `body`, ..., or `placement`.
        values: Key of the record -> value; None is its default.
        raw: The keys of the entry as they stand in the file.
        short_forms: Whether the format of the file has `rpy`.

    Returns:
        Key of the file -> plain value, None to take it away; empty when the file says all of it already.

    Raises:
        UnknownName: The record has no such key.
        InvalidRecord: A pose or a part is not what it should be.
    """
    record = _RECORDS_IN_FILES.get((table, short_forms), RECORDS[table])
    found: dict[str, Any] = {}
    for key, value in values.items():
        if key not in record.model_fields:
            raise UnknownName(f"key of [[{table}]]", key, tuple(record.model_fields))
        before = _said(table, record, raw)
        default = record.model_fields[key].get_default()
        value = default if value is None else _whole(key, value)
        if before is not None and (key in raw or key == "pose") and is_same(_dumped(getattr(before, key)), _dumped(value)):
            continue
        if key == "pose":
            found |= pose_keys(value, raw, has_rpy=short_forms and table != PLACEMENT)
        elif is_same(_dumped(value), _dumped(default)):
            found |= {key: None} if key in raw else {}
        elif key == "points":
            written = raw.get("points", [])
            found[key] = [
                short_pose(pose, written[k] if k < len(written) else None) for k, pose in enumerate(as_several(value, key))
            ]
        else:
            found[key] = plain(key, _dumped(value))
    return found


def _whole(key: str, value: Any) -> Any:
    """Return a part such as `arc` as its record."""
    kind = _INNER.get(key)
    return kind(**value) if kind is not None and isinstance(value, Mapping) else value


def _dumped(value: Any) -> Any:
    return value.model_dump(exclude_defaults=True) if isinstance(value, Spec) else plain_numbers(value)


def plain_numbers(value: Any) -> Any:
    """Return arrays of numpy as lists."""
    return value.tolist() if hasattr(value, "tolist") else value


def _said(table: str, record: type[Spec], raw: Mapping[str, Any]) -> Spec | None:
    """Return what an entry says now; None when it is not valid."""
    try:
        return record(**write_out(table, dict(raw))[0])
    except (RlbenchPinError, ShortFormError, TypeError):
        return None


_RECORDS_IN_FILES: Mapping[tuple[str, bool], type[Spec]] = {(PLACEMENT, True): TablePlacement}
"""What differs between a record and what the file says: heights of format 2 count from the table top."""
