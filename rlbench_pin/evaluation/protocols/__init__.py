"""Published protocols: tasks, episodes and limits of an evaluation, fixed in one TOML file each."""

from rlbench_pin.evaluation.protocols.protocol import (
    SPLITS,
    Protocol,
    ProtocolConflict,
    ProtocolError,
    ProtocolFileError,
    ProtocolTask,
    ProtocolTasksMissing,
    Split,
    load_protocol,
    protocol_names,
)

__all__ = [
    "SPLITS",
    "Protocol",
    "ProtocolConflict",
    "ProtocolError",
    "ProtocolFileError",
    "ProtocolTask",
    "ProtocolTasksMissing",
    "Split",
    "load_protocol",
    "protocol_names",
]
