"""The page about scene files, from the records that the reader fills and the kinds of their values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, MaxLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from reference_lib.docs import attribute_docs, doc_of, shown, table
from rlbench_pin.errors import shown as shortened
from rlbench_pin.scene.reader import SHORT_KEYS, TablePlacement
from rlbench_pin.scene.spec import (
    MAX_ELEMENTS,
    MAX_WAYPOINTS,
    ArcSpec,
    Kind,
    PlacementSpec,
    PosedSpec,
    SceneSpec,
    Spec,
    SpringSpec,
)

INNER: Mapping[str, type[Spec]] = {"joint.spring": SpringSpec, "waypoint.arc": ArcSpec}
"""Tables inside tables."""
_SHORT_TYPES = {"rpy": ("3 numbers", "rad", "-2 pi to 2 pi"), "poses": ("list of pose", "m, rad", f"at most {MAX_ELEMENTS}")}
HEAD = ("Key", "Type", "Unit", "Default", "Bounds", "Meaning")


def tables() -> dict[str, type[BaseModel]]:
    """Return the tables of a file -> what the reader makes of one entry."""
    found: dict[str, type[BaseModel]] = {}
    for name, info in SceneSpec.model_fields.items():
        record = record_in(info.annotation)
        if record is not None:
            found[name] = TablePlacement if name == "placement" else record
    return {**found, **INNER}


def parts() -> dict[str, str]:
    """Return what the page has generated, by marker."""
    made = {name.replace(".", "-"): _section(name, record) for name, record in tables().items()}
    return {"posed": _table(PosedSpec, PosedSpec.model_fields, tuple(SHORT_KEYS)), **made}


def record_in(annotation: Any) -> type[BaseModel] | None:
    """Return the record inside an annotation such as `tuple[BodySpec, ...]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := record_in(part)) is not None), None)


def _section(name: str, record: type[BaseModel]) -> str:
    """Say what a table is, then its keys but those that everything with a place has."""
    own = [key for key in record.model_fields if not (issubclass(record, PosedSpec) and key in PosedSpec.model_fields)]
    most = "" if name in (*INNER, "placement") else f" At most {MAX_WAYPOINTS if name == 'waypoint' else MAX_ELEMENTS}."
    what = doc_of(PlacementSpec if name == "placement" else record).first + most
    return f"{what}\n\n{_table(record, own)}" if own else what


def _table(record: type[BaseModel], keys: Iterable[str], short: Sequence[str] = ()) -> str:
    docs = attribute_docs(record)
    rows = [(f"`{key}`", *_row(record.model_fields[key]), docs[key]) for key in keys]
    for key in short:
        kind, unit, bounds = _SHORT_TYPES[key]
        rows.append((f"`{key}`", kind, unit, "left out", bounds, SHORT_KEYS[key]))
    return table(HEAD, rows)


def _row(info: FieldInfo) -> tuple[str, str, str, str]:
    """Return type, unit, default and bounds of a key."""
    kinds = list(_kinds(Annotated[info.annotation, *info.metadata] if info.metadata else info.annotation))
    texts, units = dict.fromkeys(kind.text for kind in kinds), dict.fromkeys(kind.unit for kind in kinds if kind.unit)
    bounds = [*dict.fromkeys(kind.bounds for kind in kinds if kind.bounds), *_bounds(info)]
    return " or ".join(texts), ", ".join(units), _default(info), "; ".join(bounds)


def _kinds(annotation: Any) -> Iterator[Kind]:
    """Yield what a value may be."""
    origin, inside = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        own = [extra for extra in inside[1:] if isinstance(extra, Kind)]
        yield from own[-1:] or _kinds(inside[0])
    elif origin in (Union, UnionType):
        for part in inside:
            yield from _kinds(part)
    elif origin is Literal:
        yield Kind(", ".join(f"`{shown(choice)}`" for choice in inside))
    elif origin is tuple:
        yield _several(inside)
    elif annotation is str:
        yield Kind("text")
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield Kind("table")
    elif annotation is not NoneType:
        raise TypeError(f"No page describes the type {shortened(annotation)}. Add a Kind for it.")


def _several(inside: tuple[Any, ...]) -> Kind:
    """Return the kind of a list: of any length, or of as many values as there are."""
    members = [kind for part in inside if part is not Ellipsis for kind in _kinds(part)]
    text = f"list of {members[0].text}" if Ellipsis in inside else f"{len(members)} {members[0].text}s"
    units = ", ".join(dict.fromkeys(kind.unit for kind in members if kind.unit))
    bounds = list(dict.fromkeys(kind.bounds for kind in members if kind.bounds))
    each = [f"x, y {bounds[0]}", f"z {bounds[1]}"] if len(bounds) == 2 else bounds
    return Kind(text, units, "; ".join(each))


def _bounds(info: FieldInfo) -> Iterator[str]:
    words = {Gt: ("above", "gt"), Ge: ("at least", "ge"), Le: ("at most", "le"), MaxLen: ("at most", "max_length")}
    for extra in info.metadata:
        if type(extra) in words and not any(isinstance(other, Kind) and other.bounds for other in info.metadata):
            word, attribute = words[type(extra)]
            yield f"{word} {getattr(extra, attribute):g}"


def _default(info: FieldInfo) -> str:
    if info.default is PydanticUndefined:
        return "required"
    if info.default is None:
        return "left out"
    value = list(info.default) if isinstance(info.default, tuple) else info.default
    return f"`{str(value).lower() if isinstance(value, bool) else shown(value)}`"
