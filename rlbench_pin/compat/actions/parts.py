"""Our arm and gripper modes, given a scene in place of a runtime, and in three parts: before, during and after a step."""

from __future__ import annotations

from rlbench_pin.compat.unwrap import SceneLike, runtime_of
from rlbench_pin.environment.actions.mode import Mode, as_action
from rlbench_pin.spatial import FloatArray


class ScenePart(Mode):
    """Goes in front of one of our modes in the bases of a class."""

    def action(self, scene: SceneLike, action: object) -> None:
        """Check one action, then run it to its end: the three parts below, one after the other.

        Raises:
            InvalidActionError: The action is refused; nothing has moved.
        """
        self.action_pre_step(scene, action)
        self.action_step(scene, action)
        self.action_post_step(scene, action)

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        """Check the action and command it."""
        self.values(scene, action)

    def action_step(self, scene: SceneLike, action: object) -> None:
        """Step the simulation until the action is done."""
        self.steps(runtime_of(scene), self.values(scene, action))

    def action_post_step(self, scene: SceneLike, action: object) -> None:
        """Come to rest."""

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action."""
        return (self.spec(runtime_of(scene)).size,)

    def action_bounds(self, scene: SceneLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        spec = self.spec(runtime_of(scene))
        return spec.low.copy(), spec.high.copy()

    def values(self, scene: SceneLike, action: object) -> FloatArray:
        """Return the numbers (n,) of an action, or raise InvalidActionError when it is refused."""
        runtime = runtime_of(scene)
        numbers = as_action(action, self.spec(runtime).size, type(self).__name__)
        return self.check(runtime, numbers)
