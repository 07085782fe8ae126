"""What a learner keeps from its meta-training tasks: arrays, numbers and texts in a msgpack file, nothing that can be run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rlbench_pin.datasets.storage import storing, write_whole
from rlbench_pin.evaluation.challenge.faults import ChallengeConflict
from rlbench_pin.evaluation.policies.policy_server import WireError, pack, unpack


def write_learned(path: Path, learned: Mapping[str, Any] | None) -> Path:
    """Write what was learned.

    Raises:
        WireError: It is no plain data, or more than 256 MB.
        StorageError: The disk cannot be written to.
    """
    return write_whole(path, pack({"learned": learned}))


def read_learned(path: Path) -> Mapping[str, Any] | None:
    """Return what was learned; None is nothing.

    Raises:
        ChallengeConflict: The file is damaged.
        StorageError: It cannot be read.
    """
    if not path.is_file():
        return None
    with storing(path):
        data = path.read_bytes()
    try:
        learned = unpack(data[4:])["learned"]
    except (WireError, KeyError) as error:
        raise ChallengeConflict(f"'{path}' is damaged: {error}. Delete it, and go on with `--resume`.") from error
    return learned if isinstance(learned, Mapping) else None
