"""The C functions of another simulator, which programs import as `pyrep.backend.sim`: not available here."""

from __future__ import annotations

from pyrep.errors import UnsupportedCall
from rlbench_pin.compat import add_aliases

add_aliases(__name__, ["sim"])


def __getattr__(name: str) -> object:
    """Refuse every function: there is no such simulator behind the objects."""
    if name.startswith("__"):
        raise AttributeError(name)
    raise UnsupportedCall(
        f"pyrep.backend.sim.{name}",
        "that simulator is not available.",
        "Use the classes of `pyrep.objects`, or the world at `rlbench_pin.compat.simulator.Simulator.current().world`.",
    )
