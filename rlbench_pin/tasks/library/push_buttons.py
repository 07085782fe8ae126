"""Press buttons in the requested order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.tasks import BUTTON_COLORS, Color, InOrder, JointMoved, SpawnBoundary, Task, Waypoint, fill_up_colors

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
TRAVEL = 0.003
"""How far a cap must go down [m]."""
TRIPLES = [(a, b, c) for a in BUTTON_COLORS for b in BUTTON_COLORS for c in BUTTON_COLORS if len({a, b, c}) == 3]
"""All triples of different colours, in the order of the list."""


class PushButtons(Task):
    """One to three of three buttons must go down by 3 mm in the requested order. Their bases have different colours."""

    variations_share_goals = True  # the first button of two triples may be the same
    buttons_count = 3
    """Buttons on the table."""
    sequences: Sequence[Sequence[Color]] = TRIPLES
    """Colours in the order of the requested buttons; if fewer buttons are requested, only the first colours."""
    variations = 50
    """One button of the first sequence, two of it, ..., all of it, then one button of the second sequence, ..."""

    def init_task(self) -> None:
        """Each round aims at the next button."""
        numbers = range(self.buttons_count)
        self.buttons = [self.world.body(f"button{i}") for i in numbers]
        self.presses = [JointMoved(self.world.joint(f"button{i}/cap_joint"), TRAVEL) for i in numbers]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_waypoint_ability_start(0, self._aim_at_next_button)

    def variation_count(self) -> int:
        """One for each number of buttons of the first colour sequences."""
        return self.variations

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the buttons; success is that the requested buttons were pressed in their order."""
        asked = self.sequences[variation // self.buttons_count][: 1 + variation % self.buttons_count]
        self.green = [False] * self.buttons_count
        self.boundary.clear()
        for button, color in zip(self.buttons, fill_up_colors(rng, asked, self.buttons_count, BUTTON_COLORS), strict=True):
            button.set_color(color.rgb, link="base")
            button.set_color(RED, link="cap")
            self.boundary.sample(button, rng, min_distance=0.1)
        self.register_success_conditions([InOrder(self.presses[: len(asked)])])
        self.register_rounds(len(asked))
        return self.make_instructions(**_words([color.name for color in asked]))

    def step(self) -> None:
        """Turn each cap green when it is pressed for the first time."""
        for i, press in enumerate(self.presses):
            if not self.green[i] and press.met():
                self.green[i] = True
                self.buttons[i].set_color(GREEN, link="cap")

    def _aim_at_next_button(self, waypoint: Waypoint) -> None:
        waypoint.frame.set_parent(f"button{self.round}")


def _words(names: list[str]) -> dict[str, str]:
    """Return the words for the requested buttons and for their order; the order is empty for one button."""
    first, *later = names
    nth = list(zip(later, ("second", "third", "fourth"), strict=False))
    words = {"first": first, "list": ", ".join(names), "series": _series(names), "chain": ", then ".join(names)}
    if not later:
        targets = {"these": "the button of this colour", "in_the_order": f"the button with the {first} base"}
        order = "initial then ordinals in_order before one_by_one afterwards and_then keeping_order repeat s"
        return words | targets | dict.fromkeys(order.split(), "")
    between = zip(later, later[1:], strict=False)
    pairs = [f"before the {later[0]} one", *(f"the {one} one before the {other} one" for one, other in between)]
    others = f"the {later[0]} one" if len(later) == 1 else f"the {_series(later)} ones in turn"
    return words | {
        "these": "these buttons one after another",
        "in_the_order": f"the buttons in the order {', '.join(names)}",
        "initial": "first ",
        "then": "".join(f", then the {name} one" for name in later),
        "ordinals": "".join(f", {name} the {place}" for name, place in nth),
        "in_order": " in this order",
        "before": f" {_series(pairs, last=', and ')}",
        "one_by_one": ", one by one in this sequence",
        "afterwards": f", and after that to {others}",
        "and_then": f" {_series(['first', *(f'on the {name} one {place}' for name, place in nth)])}",
        "keeping_order": ", and keep to the order",
        "repeat": f"; next, do the same on {', then on '.join(f'the {name} base' for name in later)}",
        "s": "s",
    }


def _series(names: list[str], last: str = " and ") -> str:
    """Return the names separated by commas, and `last` before the last name."""
    return last.join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
