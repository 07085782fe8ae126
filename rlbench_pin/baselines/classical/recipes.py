"""Recipes of the classical baseline: sequences of skills for instructions, with known models."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.baselines.classical.skills import (
    DOWN,
    PAD,
    Gripper,
    Moves,
    NothingFound,
    all_down,
    arc,
    both_ways,
    down,
    pick,
    place,
    placed,
    pointing,
    press,
    pull,
    sloping,
    sweep,
    touch,
)
from rlbench_pin.baselines.perception import (
    PALETTE,
    Axis,
    Cloud,
    KnownModel,
    Located,
    clusters,
    distances,
    lit_color,
    locate,
    rectangle,
)
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray


@dataclass(frozen=True)
class Instruction:
    """The words of one instruction."""

    words: tuple[str, ...]
    """Words in lower case, in order."""

    @classmethod
    def read(cls, sentence: str) -> Instruction:
        """Split a sentence into words."""
        return cls(tuple(re.findall(r"[a-z0-9]+", sentence.lower())))

    @property
    def colors(self) -> tuple[str, ...]:
        """The colour words, in order, each once."""
        return tuple(dict.fromkeys(word for word in self.words if word in PALETTE))

    def has(self, phrase: str) -> bool:
        """Return whether a word or phrase occurs; `a|b` means either."""
        text = f" {' '.join(self.words)} "
        return any(f" {choice} " in text for choice in phrase.split("|"))

    def one_of(self, words: tuple[str, ...]) -> str | None:
        """Return the first of some words that occurs; None if none occurs."""
        return next((word for word in self.words if word in words), None)


def objects(gripper: Gripper) -> list[Cloud]:
    """Return the separate objects, the largest first."""
    found = clusters(gripper.look().objects)
    if not found:
        raise NothingFound("No object is seen.")
    return found


def everything(gripper: Gripper) -> Cloud:
    """Return all points that do not belong to the table or the arm."""
    cloud = gripper.look().objects
    if len(cloud) == 0:
        raise NothingFound("No object is seen.")
    return cloud


def colored(candidates: Sequence[Cloud], name: str) -> Cloud:
    """Return the object whose colour is nearest to a word."""
    if not candidates:
        raise NothingFound(f"No object with the colour {name} is seen.")
    return min(candidates, key=lambda cloud: float(distances(lit_color(cloud.colors), name)))


def parts_colored(cloud: Cloud, rgb: Sequence[float], within: float = 0.3, least: float = 0.4) -> Cloud:
    """Return the points of a hue within `within` of that of a colour (3,), at least `least` times as bright."""
    wanted = np.array(rgb) / max(rgb)
    brightest = np.maximum(cloud.colors.max(axis=1), 1e-3)
    near = np.linalg.norm(cloud.colors / brightest[:, None] - wanted, axis=1) < within
    return cloud.where(near & (brightest > least * max(rgb)))


def bottom(cloud: Cloud) -> float:
    """Return the height of the lowest point over the table [m]."""
    return float(cloud.points[:, 2].min() - TABLE_HEIGHT)


def at(flat: FloatArray, up: float) -> FloatArray:
    """Return a point (3,) from its x, y (2,) and its height over the table [m]."""
    return np.array([flat[0], flat[1], TABLE_HEIGHT + up])


LEVELS = ("bottom", "middle", "top")
CLEAR = 0.03
"""Distance before a part at which the fingers start [m]."""


@dataclass(frozen=True)
class Door:
    """A door with a vertical hinge that the gripper pushes closed."""

    model: str
    """File of the model."""
    joint: str
    """Its hinge."""
    link: str
    """The part."""
    states: tuple[float, ...]
    """Angles of the hinge to try in the detection [rad]."""
    grip: float
    """Distance of the contact point from the hinge, as a fraction of the width."""


@dataclass(frozen=True)
class Lid:
    """A lid with a horizontal hinge that the gripper folds down."""

    model: str
    """File of the model."""
    joint: str
    """Its hinge."""
    link: str
    """The part."""
    states: tuple[float, ...]
    """Angles of the hinge to try in the detection [rad]."""
    press: float
    """Height of the tip over the hinge while it presses the lid flat [m]."""
    reach: float
    """Distance of the contact point from the hinge [m]."""


MICROWAVE_DOOR = Door("microwave/microwave", "door", "door_link", (0.8, 1.2, 1.6), 0.75)
FRIDGE_DOOR = Door("fridge/fridge", "upper_door", "upper_link", (1.4, 1.7, 1.9), 0.75)
LAPTOP = Lid("laptop/laptop", "screen_hinge", "screen", (1.5, 1.9), 0.014, 0.139)
TOILET = Lid("toilet/toilet", "seat_hinge", "seat", (1.5, 1.8), 0.016, 0.183)


def push_drawer(gripper: Gripper, asked: Instruction) -> Moves:
    """Push the open drawer into the chest."""
    level = asked.one_of(LEVELS) or "middle"
    joint = f"drawer_{level}"
    chest = locate(KnownModel.named("chest/chest_with_stops"), everything(gripper), [{joint: s} for s in (0.05, 0.1, 0.15)])
    axis, points = world_axis(chest, joint), chest.link_points(f"drawer_{level}_link")
    front, out = _outermost(points, axis.direction), chest.joints[joint]
    stations = [front + (CLEAR + PAD) * axis.direction, front + (PAD - out - 0.01) * axis.direction]
    turns = sloping(-axis.direction, (0.0, 0.3, 0.6, 0.9), (0.0, 0.785, -0.785))
    paths = [[placed(turn, p) for p in stations] for turn in turns]
    yield from sweep(gripper, paths, 0.1 * axis.direction)
    yield from gripper.shift(0.1 * axis.direction)


def pull_drawer(gripper: Gripper, asked: Instruction) -> Moves:
    """Grasp the handle of a drawer, pull it far out, release it."""
    level = asked.one_of(LEVELS) or "middle"
    joint = f"drawer_{level}"
    chest = locate(KnownModel.named("chest/chest"), everything(gripper), [{joint: s} for s in (0.0, 0.05, 0.1)])
    axis, points = world_axis(chest, joint), chest.link_points(f"drawer_{level}_link")
    bar = _outermost(points, axis.direction) - 0.006 * axis.direction
    far = bar + (0.19 - chest.joints[joint]) * axis.direction
    level_turns = sloping(-axis.direction, (0.0,), (0.0, 0.4, -0.4, 0.785, -0.785))  # a sloping gripper loses the handle
    turns = [turn for turn in level_turns if abs(turn[2, 1]) > 0.9]
    ways = [[placed(t, bar - 0.1 * t[:, 2]), placed(t, bar), placed(t, far)] for t in turns]
    yield from pull(gripper, gripper.choose(ways))


def push_door(gripper: Gripper, door: Door) -> Moves:
    """Push an open door about its hinge until it is nearly closed."""
    found = locate(KnownModel.named(door.model), everything(gripper), [{door.joint: s} for s in door.states])
    axis, points = world_axis(found, door.joint), found.link_points(door.link)
    angle = found.joints[door.joint]
    point, outwards = _on_leaf(points, axis, door.grip)
    start = point + (CLEAR + PAD) * outwards
    angles = -np.linspace(0.0, angle - 0.1, 5)
    stations = arc(axis, start - CLEAR * outwards, angles)
    pushing = -arc(Axis(np.zeros(3), axis.direction), outwards, [-0.5 * angle])[0]
    turns = sloping(pushing, (0.0, 0.5, 1.0, 1.57), (0.0, 0.4, -0.4, 0.785, -0.785))
    paths = [[placed(turn, p) for p in (start, *stations[1:])] for turn in turns]
    yield from sweep(gripper, paths, 0.08 * outwards)
    yield from gripper.shift(0.1 * outwards)


def fold_lid(gripper: Gripper, lid: Lid) -> Moves:
    """Tip a raised lid over from behind, and press it flat."""
    found = locate(KnownModel.named(lid.model), everything(gripper), [{lid.joint: s} for s in lid.states])
    axis, points = world_axis(found, lid.joint), found.link_points(lid.link)
    angle = found.joints[lid.joint]
    point, outwards = _on_leaf(points, axis, 0.97)
    start = point + (CLEAR + PAD) * outwards
    stations = arc(axis, point + PAD * outwards, -np.linspace(0.0, angle - 0.35, 6))
    turns = both_ways([pointing(DOWN, axis.direction), pointing(DOWN, outwards - outwards[2] * np.array([0.0, 0.0, 1.0]))])
    up = np.array([0.0, 0.0, 0.1])
    yield from sweep(gripper, [[placed(t, p) for p in (start, *stations)] for t in turns], up)
    yield from gripper.shift(up)
    free = np.cross(axis.direction, np.array([0.0, 0.0, 1.0]))
    flat = axis.origin - lid.reach * free + np.array([0.0, 0.0, lid.press])
    yield from press(gripper, flat, all_down())


def world_axis(found: Located, joint: str) -> Axis:
    """Return a joint of a located model in the world."""
    axis = found.model.axis(joint, found.joints)
    return Axis(found.point(axis.origin), found.placement.rotation @ axis.direction)


def _outermost(points: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the middle (3,) [m] of those points (n, 3) [m] that are farthest along a direction, within 4 mm."""
    along = points @ direction
    last = points[along > along.max() - 0.004]
    middle = 0.5 * (last.min(axis=0) + last.max(axis=0))
    return middle + (along.max() - middle @ direction) * direction


def _on_leaf(points: FloatArray, axis: Axis, share: float) -> tuple[FloatArray, FloatArray]:
    """Return a point (3,) [m] on the outside of a door or lid, and the outward normal (3,), its opening direction there.

    Args:
        points: Surface of the door or lid (n, 3) [m].
        axis: Its hinge; the angle increases when it opens.
        share: Distance of the point from the hinge, as a fraction of the width.
    """
    offset = points - axis.origin
    offset = offset - np.outer(offset @ axis.direction, axis.direction)
    mean = offset.mean(axis=0)
    along = mean / np.linalg.norm(mean)
    outwards = np.cross(axis.direction, along)
    width = float(np.percentile(offset @ along, 99))
    near = np.abs(offset @ along - share * width) < 0.012
    surface = float(np.percentile((offset @ outwards)[near], 95))
    heights = points @ axis.direction
    middle = 0.5 * (heights.min() + heights.max()) - axis.origin @ axis.direction
    return axis.origin + middle * axis.direction + share * width * along + surface * outwards, outwards


@dataclass(frozen=True)
class Bar:
    """A handle: a bar, parallel to the hinge of its part."""

    model: str
    """File of the model."""
    joint: str
    """The hinge of the part."""
    link: str
    """The part; its x-axis points from the bar to the part."""
    middle: tuple[float, float, float]
    """Middle of the bar, in the frame of the part [m]."""
    begin: float
    """Initial angle [rad]."""
    end: float
    """Final angle [rad]."""


MICROWAVE_BAR = Bar("microwave/microwave", "door", "door_link", (-0.06, -0.255, 0.0), 0.0, 1.5)
FRIDGE_BAR = Bar("fridge/fridge", "upper_door", "upper_link", (-0.086, -0.312, -0.09), 0.0, 1.35)
HOOD_UP = Bar("hooded_grill/hooded_grill", "lid", "hood", (-0.334, 0.0, 0.042), 0.0, 1.0)
HOOD_DOWN = Bar("hooded_grill/hooded_grill", "lid", "hood", (-0.334, 0.0, 0.042), 1.2, 0.15)


def turn_bar(gripper: Gripper, bar: Bar) -> Moves:
    """Grasp a bar, move it about its hinge, release it and move back; the gripper rotates less than the part."""
    state = {bar.joint: bar.begin}
    found = locate(KnownModel.named(bar.model), everything(gripper), [state])
    axis, part = world_axis(found, bar.joint), found.placement * found.model.placement(bar.link, state)
    point = part.act(np.array(bar.middle))
    inwards = part.rotation[:, 0] * (1.0, 1.0, 0.0)
    angles = np.linspace(0.0, bar.end - bar.begin, 9)[1:]
    points = arc(axis, point, angles)
    ways = []
    for turn in _across_bar(sloping(inwards / np.linalg.norm(inwards), (0.4, 0.8), (0.0, 0.4, -0.4)), axis.direction):
        for share in (0.1, 0.4):
            turned = [pin.exp3(share * angle * axis.direction) @ turn for angle in angles]
            carried = [placed(t, p) for t, p in zip(turned, points, strict=True)]
            ways.append([placed(turn, point - 0.1 * turn[:, 2]), placed(turn, point), *carried])
    yield from pull(gripper, gripper.choose(ways))
    yield from gripper.grip(True)
    yield from gripper.shift(-0.1 * gripper.tip.rotation[:, 2])


def _across_bar(turns: list[FloatArray], bar: FloatArray) -> list[FloatArray]:
    """Return the orientations whose fingers are on both sides of a bar; `bar` (3,) is its direction."""
    return [turn for turn in turns if abs(turn[:, 1] @ bar) < 0.2]


GRATE = 0.14
"""Height of the grate of the grill [m]."""
FINGERS = 0.035
"""Distance from the tip to the outside of an open finger [m]."""


def lift_block_to_ring(gripper: Gripper, asked: Instruction) -> Moves:
    """Lift the block of the named colour to the middle of the floating ring."""
    seen = objects(gripper)
    floating = [item for item in seen if bottom(item) > 0.1]
    if not floating:
        raise NothingFound("No floating ring is seen.")
    block = colored([item for item in seen if bottom(item) < 0.03], asked.colors[0])
    middle, yaw, _ = rectangle(block.points)
    yield from pick(gripper, at(middle, 0.0225), _across(yaw, middle, block, seen))
    yield from touch(gripper, floating[0].middle, [gripper.tip.rotation, *all_down(16)])


def lift_cup(gripper: Gripper, asked: Instruction) -> Moves:
    """Grasp the cup of the named colour at its rim, with one finger inside, and lift it."""
    cups = objects(gripper)
    cup = colored(cups, asked.colors[0])
    rest = np.concatenate([other.points for other in cups if other is not cup] or [np.full((1, 3), 9.0)])
    rim = cup.points[cup.points[:, 2] > cup.points[:, 2].max() - 0.006]
    middle = 0.5 * (rim[:, :2].min(axis=0) + rim[:, :2].max(axis=0))
    radius = float(np.percentile(np.linalg.norm(rim[:, :2] - middle, axis=1), 90)) - 0.002
    yaws = np.linspace(-np.pi, np.pi, 12, endpoint=False)
    places = [middle + radius * np.array([np.cos(yaw), np.sin(yaw)]) for yaw in yaws]
    best = int(np.argmax([np.linalg.norm(rest[:, :2] - place, axis=1).min() for place in places]))
    point = at(places[best], float(cup.points[:, 2].max() - TABLE_HEIGHT) - 0.012)
    yield from pick(gripper, point, both_ways([down(float(yaws[best]))]), lift=0.2)


def lift_lid(gripper: Gripper, asked: Instruction) -> Moves:
    """Grasp the lid of the pan at its knob, the highest part, and lift it."""
    pan = everything(gripper)
    top = pan.points[:, 2].max()
    knob = pan.where(pan.points[:, 2] > top - 0.01)
    point = np.array([*knob.middle[:2], top - 0.012])
    yield from pick(gripper, point, all_down(), lift=0.14)


def bin_paper(gripper: Gripper, asked: Instruction) -> Moves:
    """Pick up the paper ball, which is the object nearest to white among the small ones, and drop it into the bin."""
    seen = objects(gripper)
    bin_, small = seen[0], [item for item in seen[1:] if item.size[2] < 0.08]
    paper = colored(small, "white")
    middle = paper.middle[:2]
    turns = _across(0.0, middle, paper, seen, count=12)
    yield from pick(gripper, at(middle, 0.023), turns, lift=0.25)
    yield from touch(gripper, at(bin_.middle[:2], 0.29), [gripper.tip.rotation, *all_down(16)])
    yield from gripper.grip(True)


def meat_off_grill(gripper: Gripper, asked: Instruction) -> Moves:
    """Pick up the named piece of meat from the grate, and place it on the table at a long side of the grill."""
    cloud = everything(gripper)
    grill = locate(KnownModel.named("grill/grill"), cloud.between(0.0, 0.142))
    pieces = [piece for piece in clusters(cloud.between(0.147, 0.25), gap=0.01) if piece.size[:2].max() < 0.2]
    middle, yaw = _meat(pieces, asked, GRATE)
    turns = both_ways([down(yaw)]) + both_ways([down(yaw + s) for s in (-0.3, 0.3)])
    yield from pick(gripper, at(middle, 0.155), turns)
    side = grill.placement.rotation[:, 1]
    places = [grill.placement.translation + sign * 0.28 * side for sign in (1.0, -1.0)]
    nearest = min(places, key=lambda p: float(np.linalg.norm(p[:2] - np.array([0.2, 0.0]))))
    yield from place(gripper, at(nearest[:2], 0.025), over=0.15)


def meat_on_grill(gripper: Gripper, asked: Instruction) -> Moves:
    """Pick up the named piece of meat from the table, and place it in the middle of the grate."""
    seen = objects(gripper)
    grill = locate(KnownModel.named("grill/grill"), seen[0])
    middle, yaw = _meat([item for item in seen[1:] if item.size[2] < 0.08], asked, 0.0)
    yield from pick(gripper, at(middle, 0.015), both_ways([down(yaw + s) for s in (0.0, -0.3, 0.3)]), lift=0.22)
    yield from place(gripper, at(grill.placement.translation[:2], GRATE + 0.018))


def unplug(gripper: Gripper, asked: Instruction) -> Moves:
    """Grasp the charger, the object in front of the socket panel, and pull it straight out."""
    cloud = everything(gripper)
    panel = locate(KnownModel.named("socket_panel/socket_panel"), cloud)
    local = (cloud.points - panel.placement.translation) @ panel.placement.rotation
    charger = local[(np.abs(local - (-0.06, 0.0, 0.15)) < (0.045, 0.05, 0.05)).all(axis=1)]
    if len(charger) < 20:
        raise NothingFound("No charger is seen at the wall.")
    middle = panel.point(0.5 * (charger.min(axis=0) + charger.max(axis=0)))
    out, across = -panel.placement.rotation[:, 0], panel.placement.rotation[:, 1]
    turns = both_ways([pointing(np.cos(s) * DOWN - np.sin(s) * out, across) for s in (0.0, 0.4, 0.8)])
    way = gripper.choose([[placed(t, middle - 0.1 * t[:, 2]), placed(t, middle), placed(t, middle + 0.12 * out)] for t in turns])
    yield from pull(gripper, way)


def _meat(pieces: Sequence[Cloud], asked: Instruction, ground: float) -> tuple[FloatArray, float]:
    """Find the named piece of meat among candidates by its thickness.

    Args:
        pieces: Candidates.
        asked: Instruction with the name, chicken or steak.
        ground: Height of the surface below the pieces over the table [m].

    Returns:
        Middle x, y (2,) [m], and the heading across the piece [rad].

    Raises:
        NothingFound: There is no candidate.
    """
    word = asked.one_of(("chicken", "steak")) or "steak"
    if not pieces:
        raise NothingFound(f"No {word} is seen.")
    tall = float(np.ptp(KnownModel.named(f"{word}/{word}").points_at()[:, 2]))
    piece = min(pieces, key=lambda piece: abs(bottom(piece) + piece.size[2] - ground - tall))
    middle, yaw, sides = rectangle(piece.points)
    return middle, yaw if sides[0] < sides[1] else yaw + 0.5 * np.pi


def _across(yaw: float, middle: FloatArray, item: Cloud, others: Sequence[Cloud], count: int = 2) -> list[FloatArray]:
    """Return the downward orientations whose fingers have enough room beside the other objects.

    Without enough room it is the heading with the most room.

    Args:
        yaw: First heading of the fingers [rad].
        middle: Middle of the object (2,) [m].
        item: The object to grasp.
        others: All detected objects.
        count: Number of headings, evenly spaced over 180 degrees.
    """
    rest = np.concatenate([o.points for o in others if o is not item and bottom(o) < 0.1] or [np.full((1, 3), 9.0)])[:, :2]
    yaws = [yaw + k * np.pi / count for k in range(count)]
    room = []
    for y in yaws:
        reach = 0.06 * np.array([np.cos(y), np.sin(y)])
        room.append(min(float(np.linalg.norm(rest - (middle + s * reach), axis=1).min()) for s in (-1.0, 1.0)))
    free = [y for y, r in zip(yaws, room, strict=True) if r > FINGERS] or [yaws[int(np.argmax(room))]]
    return both_ways([down(y) for y in free])


PRESSED = 0.0455
"""Height of the tip over the table when a button cap is pressed down by 6 mm [m]; the fingers are 9.5 mm below the tip."""
RED, GREEN = (1.0, 0.0, 0.0), (0.0, 0.7, 0.15)
"""Colours of button caps and the block, and of the target square: red, green, blue from 0 to 1."""


def reach_ball(gripper: Gripper, asked: Instruction) -> Moves:
    """Move the tip to the ball of the named colour."""
    ball = colored([item for item in objects(gripper) if bottom(item) > 0.02], asked.colors[0])
    yield from touch(gripper, ball.middle, all_down())


def press_buttons(gripper: Gripper, asked: Instruction) -> Moves:
    """Press the buttons whose bases have the named colours, in the order of the instruction."""
    buttons = [(middle, cloud) for cloud in objects(gripper) for middle in _caps(cloud)]
    bases = [_base(middle, cloud) for middle, cloud in buttons]
    for name in asked.colors:
        base = colored(bases, name)
        middle = next(m for (m, _), b in zip(buttons, bases, strict=True) if b is base)
        yield from press(gripper, at(middle, PRESSED), all_down())


def press_lamp_button(gripper: Gripper, asked: Instruction) -> Moves:
    """Press the red cap of the lamp button."""
    caps = [middle for cloud in objects(gripper) for middle in _caps(cloud)]
    if not caps:
        raise NothingFound("No cap of a button is seen.")
    yield from press(gripper, at(caps[0], PRESSED), all_down())


def flip_switch(gripper: Gripper, asked: Instruction) -> Moves:
    """Push the raised half of the rocker switch in, with a gripper that slopes down towards the wall."""
    states = [{"rocker_joint": -0.6}, {"rocker_joint": 0.6}]
    panel = locate(KnownModel.named("switch_panel/switch_panel"), everything(gripper), states)
    inwards = panel.placement.rotation[:, 0]
    upper = panel.joints["rocker_joint"] < 0.0
    end = panel.point(np.array([-0.022, 0.0, 0.15 if upper else 0.11]))
    turns = [turn for turn in sloping(inwards, (1.27,)) if abs(turn[2, 1]) < 0.1]  # fingers side by side
    before = -0.06 * inwards
    yield from sweep(gripper, [[placed(turn, end + before), placed(turn, end)] for turn in turns], 0.04 * -inwards)
    yield from gripper.shift(before)


def shove_block(gripper: Gripper, asked: Instruction) -> Moves:
    """Push the red block onto the green square, with at most three pushes and a new detection before each."""
    view = gripper.look()
    square = max(clusters(parts_colored(view.marks, GREEN, 0.4)), key=len, default=None)
    for _ in range(3):
        block = max(clusters(parts_colored(gripper.look().objects, RED)), key=len, default=None)
        if square is None or block is None:
            raise NothingFound("No red block or no green square is seen.")
        way = square.middle[:2] - block.middle[:2]
        length = float(np.linalg.norm(way))
        if length < 0.02:
            return
        yield from _shove(gripper, block.middle[:2], way / length, length)


def _shove(gripper: Gripper, block: FloatArray, along: FloatArray, length: float) -> Moves:
    """Push a block of 6 cm at x, y (2,) [m] straight along a direction (2,) over a length [m], and move up."""
    start, up = block - 0.075 * along, np.array([0.0, 0.0, 0.12])
    end = block + (length - 0.04) * along
    forward = np.array([*along, 0.0])
    turns = both_ways([pointing(DOWN, np.cross(forward, DOWN)), pointing(DOWN, forward)])
    yield from sweep(gripper, [[placed(t, at(start, 0.03)), placed(t, at(end, 0.03))] for t in turns], up)
    yield from gripper.shift(up)


def _caps(cloud: Cloud) -> list[FloatArray]:
    """Return the middles x, y (2,) [m] of small red parts at the height of button caps."""
    level = cloud.between(0.035, 0.05)
    return [
        part.middle[:2]
        for part in clusters(parts_colored(level, RED, least=0.65), gap=0.008, fewest=15)
        if part.size[:2].max() < 0.05
    ]


def _base(middle: FloatArray, cloud: Cloud) -> Cloud:
    """Return the points of the base of a button with its middle at x, y (2,) [m]; the cap is left out."""
    apart = np.linalg.norm(cloud.points[:, :2] - middle, axis=1)
    return cloud.where((apart > 0.024) & (apart < 0.045))


Play = Callable[[Gripper, Instruction], Moves]
"""A recipe as a function of the gripper and the instruction."""


@dataclass(frozen=True)
class Recipe:
    """Words of an instruction, and the function for such instructions."""

    objects: str
    """Words or phrases of which one must occur: `a|b`."""
    asks: str
    """Further words of which one must occur; empty for none."""
    play: Play
    """The function to execute."""

    def fits(self, asked: Instruction) -> bool:
        """Return whether an instruction matches this recipe."""
        return asked.has(self.objects) and (not self.asks or asked.has(self.asks))


def _door(door: Door) -> Play:
    """Return `push_door` for one door."""
    return lambda gripper, asked: push_door(gripper, door)


def _bar(bar: Bar) -> Play:
    """Return `turn_bar` for one handle."""
    return lambda gripper, asked: turn_bar(gripper, bar)


def _lid(lid: Lid) -> Play:
    """Return `fold_lid` for one lid."""
    return lambda gripper, asked: fold_lid(gripper, lid)


_SHUT = "close|shut|shove|push|down|closed|back|bring|fold|swing|lower"
RECIPES: tuple[Recipe, ...] = (
    Recipe("paper", "", bin_paper),
    Recipe("switch|rocker|light at the wall", "", flip_switch),
    Recipe("lamp|light", "", press_lamp_button),
    Recipe("button|buttons|click|hit|operate", "", press_buttons),
    Recipe("ring|marker", "block|cube|blocks", lift_block_to_ring),
    Recipe("block|cube", "square|field|mark", shove_block),
    Recipe("cup", "lift|pick|take|raise", lift_cup),
    Recipe("lid|cover", "pan|saucepan|pot|knob", lift_lid),
    Recipe("charger|adapter|plug", "pull|take|out|draw", unplug),
    Recipe("chicken|steak", "lay the chicken on the grate|lay the steak on the grate|onto|cook", meat_on_grill),
    Recipe("chicken|steak", "table|beside|side|sides", meat_off_grill),
    Recipe("drawer|drawers|compartment|compartments", "pull|open|draw|slide", pull_drawer),
    Recipe("drawer|compartment", _SHUT, push_drawer),
    Recipe("grill|barbecue", "raise|up|open the grill", _bar(HOOD_UP)),
    Recipe("grill|barbecue", "down|lower|close", _bar(HOOD_DOWN)),
    Recipe("microwave", "wide|pull|almost", _bar(MICROWAVE_BAR)),
    Recipe("fridge|refrigerator", "wide|pull|shelves", _bar(FRIDGE_BAR)),
    Recipe("microwave", _SHUT, _door(MICROWAVE_DOOR)),
    Recipe("fridge|refrigerator|milk", _SHUT, _door(FRIDGE_DOOR)),
    Recipe("laptop|computer|notebook", _SHUT, _lid(LAPTOP)),
    Recipe("toilet|seat", "lower|down|sit", _lid(TOILET)),
    Recipe("ball|sphere", "move|touch|go", reach_ball),
)


TASKS = (
    "reach_target", "push_button", "push_buttons", "lamp_on", "lamp_off", "press_switch", "slide_block_to_target",
    "pick_and_lift", "pick_up_cup", "take_lid_off_saucepan", "put_rubbish_in_bin", "meat_off_grill", "meat_on_grill",
    "unplug_charger", "close_drawer", "open_drawer", "close_microwave", "open_microwave", "close_fridge", "open_fridge",
    "close_grill", "open_grill", "close_laptop_lid", "toilet_seat_down",
)  # fmt: skip
"""The tasks of the recipes, for evaluations; the policy does not use them."""


def find_recipe(asked: Instruction) -> Play:
    """Return the function for an instruction: the first recipe that matches it.

    Raises:
        NothingFound: There is no recipe for it.
    """
    for recipe in RECIPES:
        if recipe.fits(asked):
            return recipe.play
    raise NothingFound(f"There is no recipe for '{' '.join(asked.words)}'.")
