"""What the Python says in forms of things that are no more: grasps, conditions and random places that name them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from rlbench_pin.builder.document.behaviour.behaviour import Behaviour
from rlbench_pin.builder.document.behaviour.forms import ConditionForm, Named, SpawnForm
from rlbench_pin.builder.document.errors import EditRefused

_FIELDS = ("graspable", "success", "failure", "placements")


def without_names(python: str, names: Collection[str]) -> str:
    """Return the Python whose forms name none of these things any more; what no form can edit stays.

    Args:
        python: The text.
        names: Things of the scene that go.
    """
    for field in _FIELDS:
        behaviour = Behaviour.of(python)
        said = getattr(behaviour, field)
        if said is None:
            continue
        kept = tuple(part for part in (_without(part, names) for part in said) if part is not None)
        if kept != said:
            try:
                python = behaviour.written(field, kept)
            except EditRefused:
                continue
    return python


def _without(part: Any, names: Collection[str]) -> Any:
    """Return a part of a field without what names them; None where it says nothing else."""
    if isinstance(part, SpawnForm):
        things = tuple(spawned for spawned in part.things if not _is_about(spawned.thing, names))
        regions = tuple(region for region in part.regions if region not in names)
        return replace(part, regions=regions, things=things) if regions and (things or not part.things) else None
    return None if _is_about(part, names) else part


def _is_about(part: object, names: Collection[str]) -> bool:
    """Whether a name, or a condition with all that it is made of, names one of them."""
    if isinstance(part, Named):
        return part.name in names or part.name.partition("/")[0] in names
    if isinstance(part, ConditionForm):
        return _is_about(part.arguments, names)
    if isinstance(part, Mapping):
        return any(_is_about(value, names) for value in part.values())
    if isinstance(part, tuple):
        return any(_is_about(value, names) for value in part)
    return isinstance(part, str) and part.partition("/")[0] in names
