"""The conditions that forms can make, read from their classes."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from functools import cache

from rlbench_pin.builder.document.behaviour.forms import ConditionKind, Parameter, ParameterKind
from rlbench_pin.tasks import conditions
from rlbench_pin.tasks.conditions import Condition

AUTOMATIC: Mapping[str, str] = {"SimRobot": "self.robot", "SimGripper": "self.gripper"}
"""What a task has itself: type -> how it is written."""
_KINDS: Mapping[str, ParameterKind] = {
    "Body": "body",
    "Body | Frame": "place",
    "ObjectJoint": "joint",
    "Frame": "frame",
    "Sensor": "sensor",
    "float": "number",
    "int": "whole",
    "bool": "flag",
    "Sequence[float]": "numbers",
    "Sequence[Sequence[float]] | FloatArray": "points",
    "Sequence[Condition]": "conditions",
    "Sequence[Body | Frame]": "places",
}
"""Type of an argument -> what a form asks for."""
_ARGUMENT = re.compile(r"^ *(\w+): (.*(?:\n +(?!\w+: ).*)*)", re.MULTILINE)


@cache
def condition_kinds() -> tuple[ConditionKind, ...]:
    """Return every condition whose arguments a form can ask for, by name."""
    found = (_kind(getattr(conditions, name)) for name in sorted(conditions.__all__))
    return tuple(kind for kind in found if kind is not None)


@cache
def arguments_of(kind: str) -> Mapping[str, str]:
    """Return all arguments of a condition, in order: name -> `self.robot` or `self.gripper`, empty for those of a form."""
    parameters = inspect.signature(getattr(conditions, kind)).parameters
    return {name: AUTOMATIC.get(str(parameter.annotation), "") for name, parameter in parameters.items()}


def kind_of(name: str) -> ConditionKind | None:
    """Return the condition of that name, None when no form can make it."""
    return next((kind for kind in condition_kinds() if kind.name == name), None)


def _kind(cls: type[Condition]) -> ConditionKind | None:
    if inspect.isabstract(cls):
        return None
    texts = _argument_texts(cls)
    parameters = []
    for name, parameter in inspect.signature(cls).parameters.items():
        annotation = str(parameter.annotation)
        if annotation in AUTOMATIC:
            continue
        kind = _KINDS.get(annotation.removesuffix(" | None"))
        if kind is None:
            return None
        required = parameter.default is inspect.Parameter.empty
        default = None if required else parameter.default
        parameters.append(Parameter(name, kind, texts.get(name, ""), required, default))
    return ConditionKind(cls.__name__, _paragraph(inspect.getdoc(cls) or ""), tuple(parameters))


def _argument_texts(cls: type[Condition]) -> dict[str, str]:
    """Return what docstrings say of arguments; a class says more than the one it derives from."""
    texts: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        _, _, said = inspect.cleandoc(base.__doc__ or "").partition("\nArgs:\n")
        texts |= {name: " ".join(text.split()) for name, text in _ARGUMENT.findall(said)}
    return texts


def _paragraph(text: str) -> str:
    return " ".join(text.partition("\n\n")[0].split())
