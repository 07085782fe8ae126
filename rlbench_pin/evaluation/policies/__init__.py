"""Policies: what acts on observations, and how it is reached, in this process, in one of its own or over a socket."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.evaluation.policies.adapters.function import FunctionPolicy
from rlbench_pin.evaluation.policies.adapters.key_frames import KeyFrame, KeyFramePolicy
from rlbench_pin.evaluation.policies.adapters.trivial import Random, Rest
from rlbench_pin.evaluation.policies.client import PolicyClient, open_policy
from rlbench_pin.evaluation.policies.faults import (
    FaultKind,
    LibraryMissing,
    PolicyFault,
    PolicyReferenceError,
    PolicySettingsError,
)
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext
from rlbench_pin.evaluation.policies.references import BUILT_IN, Reference, find_policy
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.front_door import front_door

__all__ = [
    "BUILT_IN",
    "FaultKind",
    "FunctionPolicy",
    "KeyFrame",
    "KeyFramePolicy",
    "LibraryMissing",
    "Policy",
    "PolicyClient",
    "PolicyContext",
    "PolicyFault",
    "PolicyReferenceError",
    "PolicySettings",
    "PolicySettingsError",
    "Random",
    "Reference",
    "Rest",
    "find_policy",
    "open_policy",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
