"""Replacement for `pyrep.backend.sim`, the C functions of another simulator, which are not available."""

from __future__ import annotations

from pyrep.errors import UnsupportedCall
from rlbench_pin.compat import add_aliases

add_aliases(__name__, ["sim"])


def __getattr__(name: str) -> object:
    """Raise UnsupportedCall for each function."""
    if name.startswith("__"):
        raise AttributeError(name)
    raise UnsupportedCall(
        f"pyrep.backend.sim.{name}",
        "that simulator is not available.",
        "Use the classes of `pyrep.objects`, or the world at `rlbench_pin.compat.simulator.Simulator.current().world`.",
    )
