"""Press buttons in the asked order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.tasks import BUTTON_COLORS, Color, InOrder, JointMoved, SpawnBoundary, Task, Waypoint, fill_up_colors

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
TRAVEL = 0.003
"""How far a cap must go down [m]."""
TRIPLES = [(a, b, c) for a in BUTTON_COLORS for b in BUTTON_COLORS for c in BUTTON_COLORS if len({a, b, c}) == 3]
"""Three different colours, in the order of the list."""


class PushButtons(Task):
    """One to three of three buttons, which differ by the colours of their bases, must go down 3 mm in the asked order."""

    variations_share_goals = True  # the first button of two triples may be the same
    buttons_count = 3
    """Buttons on the table."""
    sequences: Sequence[Sequence[Color]] = TRIPLES
    """Colours in the order in which their buttons are asked for; where fewer are asked for, the first ones."""
    variations = 50
    """One button of the first sequence, two of it, ... all of it, one of the second, ..."""

    def init_task(self) -> None:
        """Each round aims at the next button."""
        numbers = range(self.buttons_count)
        self.buttons = [self.world.body(f"button{i}") for i in numbers]
        self.presses = [JointMoved(self.world.joint(f"button{i}/cap_joint"), TRAVEL) for i in numbers]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_waypoint_ability_start(0, self._aim_at_next_button)

    def variation_count(self) -> int:
        """One to all buttons of the first sequences of colours."""
        return self.variations

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the buttons; success is that the asked ones were pressed in their order."""
        asked = self.sequences[variation // self.buttons_count][: 1 + variation % self.buttons_count]
        self.green = [False] * self.buttons_count
        self.boundary.clear()
        for button, color in zip(self.buttons, fill_up_colors(rng, asked, self.buttons_count, BUTTON_COLORS), strict=True):
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
    after = zip(later, ("second", "third", "fourth"), strict=False)
    return [
        f"Press the {first} button{''.join(f', then the {name} one' for name in later)}.",
        f"{first.capitalize()} is the {'first ' * bool(later)}button to click{''.join(f', {c} the {nth}' for c, nth in after)}.",
        f"Push {'these buttons one after another' if later else 'the button of this colour'}: {', '.join(names)}.",
    ]
