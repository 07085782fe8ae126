"""What users' own arm and gripper modes derive from."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.compat.unwrap import SceneLike
from rlbench_pin.spatial import FloatArray

Action = Sequence[float] | FloatArray


class UserMode:
    """A mode whose methods users write; what is not written says so when it is called."""

    def action(self, scene: SceneLike, action: Action) -> None:
        """Run one action to its end."""
        raise self._missing("action(scene, action)")

    def action_pre_step(self, scene: SceneLike, action: Action) -> None:
        """Command the motors, before the simulation is stepped."""
        raise self._missing("action_pre_step(scene, action)")

    def action_step(self, scene: SceneLike, action: Action) -> None:
        """Step the simulation."""
        raise self._missing("action_step(scene, action)")

    def action_post_step(self, scene: SceneLike, action: Action) -> None:
        """Come to rest, after the simulation was stepped."""
        raise self._missing("action_post_step(scene, action)")

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int, ...]:
        """Return the shape of an action."""
        raise self._missing("action_shape(scene)", " that returns a tuple")

    def action_bounds(self, scene: SceneLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        raise self._missing("action_bounds()", " for this use, such as gymnasium")

    def _missing(self, method: str, purpose: str = "") -> NotImplementedError:
        return NotImplementedError(f"{type(self).__name__} needs a method `{method}`{purpose}.")
