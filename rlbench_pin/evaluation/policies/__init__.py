"""Policies, which map observations to actions, in this process, in a subprocess or behind a socket."""

from rlbench_pin.evaluation.policies.adapters import FunctionPolicy, KeyFrame, KeyFramePolicy, Noop, Random
from rlbench_pin.evaluation.policies.client import PolicyClient, open_policy
from rlbench_pin.evaluation.policies.mapping import MappingError, PolicyMapping, load_mapping, mapping_names
from rlbench_pin.evaluation.policies.policy import (
    FaultKind,
    LibraryMissing,
    Policy,
    PolicyContext,
    PolicyFault,
    PolicyOfAnotherArm,
    PolicyReferenceError,
    PolicySettingsError,
)
from rlbench_pin.evaluation.policies.references import BUILT_IN, Reference, find_policy
from rlbench_pin.evaluation.policies.settings import PolicySettings

__all__ = [
    "BUILT_IN",
    "FaultKind",
    "FunctionPolicy",
    "KeyFrame",
    "KeyFramePolicy",
    "LibraryMissing",
    "MappingError",
    "Noop",
    "Policy",
    "PolicyClient",
    "PolicyContext",
    "PolicyFault",
    "PolicyMapping",
    "PolicyOfAnotherArm",
    "PolicyReferenceError",
    "PolicySettings",
    "PolicySettingsError",
    "Random",
    "Reference",
    "find_policy",
    "load_mapping",
    "mapping_names",
    "open_policy",
]
