"""What runs in the children of `test_child.py`: sends what it sees back, then does what its first argument says."""

from __future__ import annotations

import os
import subprocess
import sys

from rlbench_pin.processes.child import connect_to_owner, limit_memory

_DAEMONS = "for i in $(seq 20); do setsid sleep 600 > /dev/null 2>&1 & echo $!; done"
"""Processes in sessions of their own, whose parent ends at once."""


def main() -> None:
    """Say hello, then misbehave."""
    connection, (fault, *_) = connect_to_owner()
    sys.stdout.write(f"started {os.environ.get('FLAVOUR')}\n")
    connection.sendall(connection.recv(100).upper())
    if fault == "exit":
        sys.exit(3)
    if fault == "memory":
        limit_memory(2**26)
        bytearray(2**27)
    if fault.startswith("daemons"):
        said = subprocess.run(["/bin/sh", "-c", _DAEMONS], env={"PATH": os.defpath}, stdout=subprocess.PIPE, check=True).stdout
        connection.sendall(said)
        if fault == "daemons crash":
            os.abort()
    connection.recv(1)


if __name__ == "__main__":
    main()
