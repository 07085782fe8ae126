"""The state of a physics server as bytes, which a server with the same bodies can go on from."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim.client import PhysicsClient, bullet

_BEGINNING, _LEAST = b"BULLET", 64
_MEMORY = "/dev/shm"
"""Files there are on no disk, and six times as fast; where it is missing, the system's folder for temporary files is used."""


def to_bytes(client: PhysicsClient) -> bytes:
    """Return the state of a physics server as bytes."""
    with _temporary_file() as file:
        bullet.saveBullet(str(file), physicsClientId=client.id)
        return file.read_bytes()


def restore_bytes(client: PhysicsClient, physics: bytes) -> None:
    """Bring a physics server to the state of `to_bytes`.

    Raises:
        RlbenchPinError: The bytes are damaged, or hold other bodies.
    """
    problem = "The array 'physics' does not fit this world; it holds other bodies or is damaged."
    if not physics.startswith(_BEGINNING) or len(physics) < _LEAST:
        raise RlbenchPinError(problem)
    with _temporary_file() as file:
        file.write_bytes(physics)
        try:
            client.restore(fileName=str(file))
        except bullet.error as error:
            raise RlbenchPinError(problem) from error


@contextmanager
def _temporary_file() -> Iterator[Path]:
    """Yield a path that was never used before, for PyBullet remembers what it has read by the name of the file."""
    memory = _MEMORY if os.access(_MEMORY, os.W_OK | os.X_OK) else None
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        yield Path(folder) / "state.bullet"
