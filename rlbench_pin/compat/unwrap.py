"""From what programs hold in their hands, a scene, to what our own code works on, a runtime."""

from __future__ import annotations

from typing import Any, Protocol

from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.observation import Observation


class HasRuntime(Protocol):
    """A scene in front of a runtime."""

    @property
    def runtime(self) -> Runtime:
        """World, task and planner together."""
        ...

    @property
    def robot(self) -> Any:
        """Arm and gripper."""
        ...

    def step(self) -> None:
        """Advance one control tick."""
        ...

    def get_observation(self) -> Observation:
        """Observe without stepping."""
        ...


SceneLike = HasRuntime | Runtime
"""What action modes are given: a scene, or a runtime itself."""


def runtime_of(scene: SceneLike | None) -> Runtime:
    """Return the runtime of a scene; of a runtime itself; of the simulator of this process when there is no scene.

    Raises:
        TypeError: `scene` is something else.
    """
    if scene is None:
        return Simulator.current().runtime
    if isinstance(scene, Runtime):
        return scene
    runtime = getattr(scene, "runtime", None)
    if not isinstance(runtime, Runtime):
        raise TypeError(
            f"An action mode takes a scene, not {type(scene).__name__}: `rlbench.backend.scene.Scene` or a class derived from it."
        )
    return runtime
