"""Success conditions as text, and whether they hold, looked at without changing what they remember."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rlbench_pin.tasks import (
    AllOf,
    AnyOf,
    Condition,
    Detected,
    DetectedSeveral,
    FollowPath,
    Grasped,
    HasColor,
    InOrder,
    JointMoved,
    ListEmpty,
    NothingGrasped,
    Task,
    TipInside,
)


def looked_at(conditions: Sequence[Condition]) -> tuple[bool, ...]:
    """Return whether each condition holds now; those that keep count are left as they were."""
    before = [condition.state() for condition in conditions]
    try:
        return tuple(bool(condition.met()) for condition in conditions)
    finally:
        for condition, state in zip(conditions, before, strict=True):
            condition.set_state(state)


def success_texts(task: Task) -> tuple[str, ...]:
    """Return what has to be met for success, as text, in order."""
    return tuple(condition_text(condition) for condition in task.get_success_conditions())


def condition_text(condition: Condition) -> str:
    """Return what a condition asks for in a few words; for one that a task file defines, the name of its class."""
    for kind, text in _TEXTS:
        if isinstance(condition, kind):
            return text(condition)
    return type(condition).__name__


def _detected(condition: Detected) -> str:
    return f"{condition.thing.name} {'outside' if condition.negated else 'inside'} {condition.sensor.name}"


def _several(condition: DetectedSeveral) -> str:
    names = ", ".join(thing.name for thing in condition.things)
    return f"at least {condition.count} of {names} inside {condition.sensor.name}"


def _path(condition: FollowPath) -> str:
    return f"{condition.body.name} visits {len(condition.points)} points in order"


def _color(condition: HasColor) -> str:
    return f"{condition.body.name} has colour {', '.join(f'{part:.3g}' for part in condition.rgb)}"


def _combined(words: str) -> Callable[[AllOf | AnyOf | InOrder], str]:
    return lambda condition: f"{words} ({'; '.join(condition_text(member) for member in condition.members)})"


_TEXTS: tuple[tuple[type[Condition], Callable[..., str]], ...] = (
    (Detected, _detected),
    (DetectedSeveral, _several),
    (TipInside, lambda condition: f"tip inside {condition.sensor.name}"),
    (FollowPath, _path),
    (Grasped, lambda condition: f"{condition.body.name} grasped"),
    (NothingGrasped, lambda condition: "nothing grasped"),
    (HasColor, _color),
    (JointMoved, lambda condition: f"{condition.joint.name} moved by more than {condition.distance:.4g}"),
    (ListEmpty, lambda condition: "list of the task empty"),
    (AllOf, _combined("all of")),
    (AnyOf, _combined("any of")),
    (InOrder, _combined("in order")),
)
