"""Versions of the libraries that shape a demonstration."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

LIBRARIES = ("rlbench_pin", "pin", "coal", "pybullet", "ompl", "toppra", "placo", "osqp", "numpy")


def library_versions() -> dict[str, str]:
    """Return name -> version of this package and the libraries that shape a demonstration; `unknown` without metadata."""
    return {name: _version(name) for name in LIBRARIES}


def _version(name: str) -> str:
    try:
        return version(name.replace("_", "-"))
    except PackageNotFoundError:  # a source tree that was never installed
        return "unknown"
