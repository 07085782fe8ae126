"""What runs in the children of `test_child.py`: sends what it sees back, then does what its first argument says."""

from __future__ import annotations

import os
import subprocess
import sys

from rlbench_pin.processes.child import connect_to_owner, limit_memory


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
    if fault == "daemon":
        process = subprocess.Popen(["sleep", "600"], start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        connection.sendall(str(process.pid).encode())
    connection.recv(1)


if __name__ == "__main__":
    main()
