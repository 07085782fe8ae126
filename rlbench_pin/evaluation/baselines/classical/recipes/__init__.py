"""Which recipe an instruction asks for: the first whose words occur."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rlbench_pin.evaluation.baselines.classical.errors import NothingFound
from rlbench_pin.evaluation.baselines.classical.instruction import Instruction
from rlbench_pin.evaluation.baselines.classical.recipes import bars, parts, picking, pressing
from rlbench_pin.evaluation.baselines.classical.skills import Hand, Moves

Play = Callable[[Hand, Instruction], Moves]


@dataclass(frozen=True)
class Recipe:
    """Words and what to do about them."""

    things: str
    """One of these words, or phrases, occurs: `a|b`."""
    asks: str
    """And one of these; empty asks for nothing more."""
    play: Play
    """What to do."""

    def fits(self, asked: Instruction) -> bool:
        """Say whether an instruction asks for this."""
        return asked.has(self.things) and (not self.asks or asked.has(self.asks))


def _door(door: parts.Door) -> Play:
    return lambda hand, asked: parts.push_door(hand, door)


def _bar(bar: bars.Bar) -> Play:
    return lambda hand, asked: bars.turn_bar(hand, bar)


def _lid(lid: parts.Lid) -> Play:
    return lambda hand, asked: parts.fold_lid(hand, lid)


_SHUT = "close|shut|shove|push|down|closed|back|bring|fold|swing"
RECIPES: tuple[Recipe, ...] = (
    Recipe("paper", "", picking.bin_paper),
    Recipe("lamp", "", pressing.press_lamp_button),
    Recipe("button|buttons|click|hit|operate", "", pressing.press_buttons),
    Recipe("switch|rocker", "", pressing.flip_switch),
    Recipe("ring|marker", "block|cube|blocks", picking.lift_block_to_ring),
    Recipe("block|cube", "square|field|mark", pressing.shove_block),
    Recipe("cup", "lift|take|raise", picking.lift_cup),
    Recipe("lid|cover", "pan|saucepan|pot|knob", picking.lift_lid),
    Recipe("charger|adapter|plug", "pull|take|out|draw", picking.unplug),
    Recipe("chicken|steak", "lay the chicken on the grate|lay the steak on the grate|onto|cook", picking.meat_on_grill),
    Recipe("chicken|steak", "table|beside|side", picking.meat_off_grill),
    Recipe("drawer|compartment|compartments", "pull|open|draw", parts.pull_drawer),
    Recipe("drawer|compartment", _SHUT, parts.push_drawer),
    Recipe("grill|barbecue", "raise|up|covered", _bar(bars.HOOD_UP)),
    Recipe("grill|barbecue", "down|lower|close", _bar(bars.HOOD_DOWN)),
    Recipe("microwave", "wide|pull|nearly", _bar(bars.MICROWAVE)),
    Recipe("fridge|refrigerator", "wide|pull|shelves", _bar(bars.FRIDGE)),
    Recipe("microwave", _SHUT, _door(parts.MICROWAVE)),
    Recipe("fridge|refrigerator|milk", _SHUT, _door(parts.FRIDGE)),
    Recipe("laptop|computer|notebook", _SHUT, _lid(parts.LAPTOP)),
    Recipe("toilet|seat", "lower|down|sit", _lid(parts.TOILET)),
    Recipe("ball|sphere", "move|touch|go", pressing.reach_ball),
)


TASKS = (
    "reach_target", "push_button", "push_buttons", "lamp_on", "lamp_off", "press_switch", "slide_block_to_target",
    "pick_and_lift", "pick_up_cup", "take_lid_off_saucepan", "put_rubbish_in_bin", "meat_off_grill", "meat_on_grill",
    "unplug_charger", "close_drawer", "open_drawer", "close_microwave", "open_microwave", "close_fridge", "open_fridge",
    "close_grill", "open_grill", "close_laptop_lid", "toilet_seat_down",
)  # fmt: skip
"""The tasks that the recipes are for, as one evaluates them; the policy itself is told no task and never looks here."""


def find_recipe(asked: Instruction) -> Play:
    """Return what to do about an instruction.

    Raises:
        NothingFound: No recipe is known for it.
    """
    for recipe in RECIPES:
        if recipe.fits(asked):
            return recipe.play
    raise NothingFound(f"No recipe is known for '{' '.join(asked.words)}'.")


__all__ = ["RECIPES", "TASKS", "Recipe", "find_recipe"]
