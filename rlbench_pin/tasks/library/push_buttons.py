"""Press buttons in the asked order."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import BUTTON_COLORS, InOrder, JointMoved, SpawnBoundary, Task, Waypoint, fill_up_colors

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
TRAVEL = 0.003
"""How far a cap must go down [m]."""
TRIPLES = [(a, b, c) for a in BUTTON_COLORS for b in BUTTON_COLORS for c in BUTTON_COLORS if len({a, b, c}) == 3]
"""Three different colours, in the order of the list."""


class PushButtons(Task):
    """One to three of three buttons, which differ by the colours of their bases, must go down 3 mm in the asked order."""

    variations_share_goals = True  # the first button of two triples may be the same

    def init_task(self) -> None:
        """Each round aims at the next button."""
        self.buttons = [self.world.body(f"button{i}") for i in range(3)]
        self.presses = [JointMoved(self.world.joint(f"button{i}/cap_joint"), TRAVEL) for i in range(3)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_waypoint_ability_start(0, self._aim_at_next_button)

    def variation_count(self) -> int:
        """One to three buttons of the first triples of colours."""
        return 50

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the buttons; success is that the asked ones were pressed in their order."""
        asked = TRIPLES[variation // 3][: 1 + variation % 3]
        self.green = [False, False, False]
        self.boundary.clear()
        for button, color in zip(self.buttons, fill_up_colors(rng, asked, 3, BUTTON_COLORS), strict=True):
            button.set_color(color.rgb, link="base")
            button.set_color(RED, link="cap")
            self.boundary.sample(button, rng, min_distance=0.1)
        self.register_success_conditions([InOrder(self.presses[: len(asked)])])
        self.register_rounds(len(asked))
        return _sentences([color.name for color in asked])

    def step(self) -> None:
        """Turn each cap green when it is pressed for the first time."""
        for i, press in enumerate(self.presses):
            if not self.green[i] and press.met():
                self.green[i] = True
                self.buttons[i].set_color(GREEN, link="cap")

    def _aim_at_next_button(self, waypoint: Waypoint) -> None:
        waypoint.frame.set_parent(f"button{self.round}")


def _sentences(names: list[str]) -> list[str]:
    """Say which buttons to press, and that the order counts."""
    first, *later = names
    after = zip(later, ("second", "third"), strict=False)
    return [
        f"Press the {first} button{''.join(f', then the {name} one' for name in later)}.",
        f"{first.capitalize()} is the {'first ' * bool(later)}button to click{''.join(f', {c} the {nth}' for c, nth in after)}.",
        f"Push {'these buttons one after another' if later else 'the button of this colour'}: {', '.join(names)}.",
    ]
