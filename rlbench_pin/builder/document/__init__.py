"""The edited task: its two files as text, with unlimited undo; both files are saved together or not at all."""

from __future__ import annotations

from rlbench_pin.builder.document.behaviour import Behaviour
from rlbench_pin.builder.document.conditions import (
    Argument,
    ConditionForm,
    ConditionKind,
    Named,
    Parameter,
    Written,
    condition_kinds,
)
from rlbench_pin.builder.document.document import TaskDocument
from rlbench_pin.builder.document.drafts import Draft, DraftKeeper
from rlbench_pin.builder.document.errors import ChangedOnDisk, DocumentError, EditRefused, HasDependants, TaskFilesError
from rlbench_pin.builder.document.placements import SpawnedForm, SpawnForm

__all__ = [
    "Argument",
    "Behaviour",
    "ChangedOnDisk",
    "ConditionForm",
    "ConditionKind",
    "DocumentError",
    "Draft",
    "DraftKeeper",
    "EditRefused",
    "HasDependants",
    "Named",
    "Parameter",
    "SpawnForm",
    "SpawnedForm",
    "TaskDocument",
    "TaskFilesError",
    "Written",
    "condition_kinds",
]
