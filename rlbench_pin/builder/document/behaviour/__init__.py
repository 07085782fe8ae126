"""What forms can edit of the Python of a task."""

from __future__ import annotations

from rlbench_pin.builder.document.behaviour.behaviour import Behaviour
from rlbench_pin.builder.document.behaviour.forms import (
    Argument,
    ConditionForm,
    ConditionKind,
    Named,
    Parameter,
    SpawnedForm,
    SpawnForm,
    Written,
)
from rlbench_pin.builder.document.behaviour.kinds import condition_kinds

__all__ = [
    "Argument",
    "Behaviour",
    "ConditionForm",
    "ConditionKind",
    "Named",
    "Parameter",
    "SpawnForm",
    "SpawnedForm",
    "Written",
    "condition_kinds",
]
