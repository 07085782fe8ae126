"""Press buttons in the asked order."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import BUTTON_COLORS, Color, InOrder, JointMoved, SpawnBoundary, Task, Waypoint

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
TRAVEL = 0.003
"""How far a cap must go down [m]."""
TRIPLES = [(a, b, c) for a in BUTTON_COLORS for b in BUTTON_COLORS for c in BUTTON_COLORS if len({a, b, c}) == 3]
"""Three different colours, in the order of the list."""


class PushButtons(Task):
    """One to three of three buttons, told apart by their bases, must go down 3 mm in the asked order."""

    variations_share_goals = True  # the first button of two triples may be the same

    def init_task(self) -> None:
        self.buttons = [self.world.body(f"button{i}") for i in range(3)]
        self.presses = [JointMoved(self.world.joint(f"button{i}/cap_joint"), TRAVEL) for i in range(3)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_waypoint_ability_start(0, self._aim_at_next_button)
        self.register_waypoints_should_repeat(self._next_round)

    def variation_count(self) -> int:
        return 50

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        triple, self.count = TRIPLES[variation // 3], 1 + variation % 3
        self.pressed, self.green = 0, [False, False, False]
        self.boundary.clear()
        for button, color in zip(self.buttons, self._colors(triple, rng), strict=True):
            button.set_color(color.rgb, link="base")
            button.set_color(RED, link="cap")
            self.boundary.sample(button, rng, min_distance=0.1)
        self.register_success_conditions([InOrder(self.presses[: self.count])])
        return _sentences([color.name for color in triple[: self.count]])

    def step(self) -> None:
        for i, press in enumerate(self.presses):
            if not self.green[i] and press.met():
                self.green[i] = True
                self.buttons[i].set_color(GREEN, link="cap")

    def _colors(self, triple: tuple[Color, ...], rng: np.random.Generator) -> list[Color]:
        """Return the colours of the three bases; those that are not asked for are drawn."""
        asked = list(triple[: self.count])
        others = [color for color in BUTTON_COLORS if color not in asked]
        return asked + [others[i] for i in rng.choice(len(others), 3 - self.count, replace=False)]

    def _aim_at_next_button(self, waypoint: Waypoint) -> None:
        waypoint.frame.set_parent(f"button{self.pressed}")

    def _next_round(self) -> bool:
        self.pressed += 1
        return self.pressed < self.count


def _sentences(names: list[str]) -> list[str]:
    """Say which buttons to press, and that the order counts."""
    listed = f"Operate these buttons one after another: {', '.join(names)}."
    if len(names) == 1:
        return [f"One press on the {names[0]} button, nothing else.", f"Push the button with the {names[0]} base.", listed]
    if len(names) == 2:
        return [f"First the {names[0]} button, afterwards the {names[1]} one.", f"Press {names[0]}, then {names[1]}.", listed]
    return [f"Hit {names[0]}, {names[1]} and {names[2]}, in this order.", f"Push the {', then the '.join(names)} button.", listed]
