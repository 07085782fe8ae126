"""The state of a physics server as bytes, which a server with the same bodies can go on from."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim.client import PhysicsClient, bullet

_BEGINNING, _LEAST = b"BULLET", 64


def to_bytes(client: PhysicsClient) -> bytes:
    """Return the state of a physics server as bytes."""
    with _file_in_memory() as (descriptor, name):
        bullet.saveBullet(name, physicsClientId=client.id)
        return os.pread(descriptor, os.fstat(descriptor).st_size, 0)


def restore_bytes(client: PhysicsClient, physics: bytes) -> None:
    """Bring a physics server to the state of `to_bytes`.

    Raises:
        RlbenchPinError: The bytes are damaged, or hold other bodies.
    """
    problem = "The array 'physics' does not fit this world; it holds other bodies or is damaged."
    if not physics.startswith(_BEGINNING) or len(physics) < _LEAST:
        raise RlbenchPinError(problem)
    with _file_in_memory() as (descriptor, name), open(descriptor, "wb", closefd=False) as file:
        file.write(physics)
        file.flush()
        try:
            bullet.restoreState(fileName=name, physicsClientId=client.id)
        except bullet.error as error:
            raise RlbenchPinError(problem) from error


@contextmanager
def _file_in_memory() -> Iterator[tuple[int, str]]:
    """Yield the descriptor and the name of a file that is on no disk."""
    descriptor = os.memfd_create("rlbench_pin_state")
    try:
        yield descriptor, f"/proc/self/fd/{descriptor}"
    finally:
        os.close(descriptor)
