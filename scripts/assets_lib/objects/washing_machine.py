"""A washing machine with a round glass door on the front."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, icosphere, lathe, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    metal,
    pane,
    patterned,
    plastic,
    shining,
)

DEPTH, WIDTH, HEIGHT, FOOT, WALL = 0.34, 0.38, 0.46, 0.012, 0.015
FRONT = -DEPTH / 2.0
"""x of the front panel [m]."""
HOLE = 0.095
"""Half the edge of the square hole in the front that the door covers [m]."""
LUMP = 0.042
"""Radius of a crumpled piece of laundry [m]."""
MIDDLE = 0.215
"""Height of the middle of the door [m]."""
RADIUS, THICK, GAP = 0.12, 0.024, 0.002
"""Of the door; and between it and the front [m]."""
HINGE = (FRONT - GAP, RADIUS + 0.004, MIDDLE)
CENTER = -RADIUS - 0.004
"""y of the middle of the door in its frame [m]."""
GRIP = (-THICK - 0.044, CENTER - 0.095, 0.0)
"""Middle of the bar of the grip in the door's frame [m]."""
BAR_RADIUS, BAR_LENGTH = 0.007, 0.09
HALF_PI = 1.57079633
WHITE, DARK, CHROME, GLASS = (
    plastic((0.93, 0.94, 0.96)),
    (0.16, 0.17, 0.20),
    metal((0.72, 0.74, 0.78)),
    pane((0.30, 0.44, 0.58), 0.40),
)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _between(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Box:
    """Return size and centre of the box between bounds."""
    size = (x[1] - x[0], y[1] - y[0], z[1] - z[0])
    return (size, ((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0, (z[0] + z[1]) / 2.0))


def _shell() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the cabinet, its front with a square hole."""
    half, back = WIDTH / 2.0, DEPTH / 2.0
    inner, low, high = (FRONT + WALL, back - WALL), FOOT + WALL, HEIGHT - WALL
    return (
        _between((FRONT, back), (-half, half), (FOOT, low)),
        _between((FRONT, back), (-half, half), (high, HEIGHT)),
        _between((FRONT, back), (half - WALL, half), (low, high)),
        _between((FRONT, back), (-half, -half + WALL), (low, high)),
        _between((inner[1], back), (-half + WALL, half - WALL), (low, high)),
        _between((FRONT, inner[0]), (-half + WALL, half - WALL), (low, MIDDLE - HOLE)),
        _between((FRONT, inner[0]), (-half + WALL, half - WALL), (MIDDLE + HOLE, high)),
        _between((FRONT, inner[0]), (HOLE, half - WALL), (MIDDLE - HOLE, MIDDLE + HOLE)),
        _between((FRONT, inner[0]), (-half + WALL, -HOLE), (MIDDLE - HOLE, MIDDLE + HOLE)),
    )


def _feet() -> tuple[Box, ...]:
    return tuple(((0.04, 0.04, FOOT), (x, y, FOOT / 2.0)) for x in (-0.13, 0.13) for y in (-0.15, 0.15))


def _drum() -> tuple[Box, ...]:
    """Return the four sides and the back of the drum, for collisions."""
    x, w = (FRONT + WALL, 0.10), HOLE + 0.008
    return (
        _between(x, (-w, w), (MIDDLE - w, MIDDLE - HOLE)),
        _between(x, (-w, w), (MIDDLE + HOLE, MIDDLE + w)),
        _between(x, (HOLE, w), (MIDDLE - HOLE, MIDDLE + HOLE)),
        _between(x, (-w, -HOLE), (MIDDLE - HOLE, MIDDLE + HOLE)),
        _between((0.10, 0.108), (-w, w), (MIDDLE - w, MIDDLE + w)),
    )


def _rim() -> Mesh:
    """Return the ring of chrome on the front that hides the corners of the hole; its axis is x."""
    profile = [(0.138, -0.001), (0.138, 0.001), (0.088, 0.001)]
    return lathe(profile, 32).moved((FRONT - 0.0005, 0.0, MIDDLE), (0.0, -HALF_PI, 0.0))


def _crumpled(ball: Mesh, rng: np.random.Generator) -> Mesh:
    """Return a ball with folds: waves along its surface in random directions."""
    waves = rng.standard_normal((3, 3))
    waves *= 1.6 / np.linalg.norm(waves, axis=1, keepdims=True)
    folds = np.cos(ball.vertices / LUMP @ waves.T * 2.0 + rng.uniform(0.0, 6.0, 3)).sum(axis=1)
    return Mesh(ball.vertices * (1.0 + 0.11 * folds)[:, None], ball.faces)


def _laundry() -> tuple[Mesh, ...]:
    """Return the crumpled clothes at the bottom of the drum, three of them."""
    rng = np.random.default_rng(3)
    lumps = [_crumpled(icosphere(LUMP, 1), rng).scaled((1.0, 1.15, 0.95)) for _ in range(3)]
    places = [(-0.06 + 0.03 * (i % 2), 0.048 * (i - 1), MIDDLE - HOLE + 0.042 - 0.004 * (i % 2)) for i in range(3)]
    return tuple(lump.moved(place) for lump, place in zip(lumps, places, strict=True))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _dial() -> Mesh:
    disc = cylinder(0.028, 0.022, 16).moved((FRONT - 0.012, -0.12, 0.40), (0.0, HALF_PI, 0.0))
    return merge([disc, box((0.01, 0.008, 0.05), (FRONT - 0.026, -0.12, 0.40))])


def _body_link() -> Link:
    panel = box((0.003, WIDTH - 0.002, 0.085), (FRONT - 0.0015, 0.0, HEIGHT - 0.058))
    soap = box((0.006, 0.11, 0.055), (FRONT - 0.003, 0.12, 0.40))
    keys = merge(box((0.006, 0.016, 0.016), (FRONT - 0.003, -0.06 + 0.026 * i, 0.385)) for i in range(4))
    top = _between((-0.15, 0.15), (-0.17, 0.17), (HEIGHT, HEIGHT + 0.002))
    back = [box((0.002, 0.26, 0.30), (DEPTH / 2.0 + 0.001, 0.0, 0.24))]
    hoses = [rod((DEPTH / 2.0 + 0.008, y, 0.06), (DEPTH / 2.0 + 0.008, y, 0.42), 0.008, 6) for y in (-0.15, 0.15)]
    plinth = box((DEPTH - 0.016, WIDTH - 0.016, FOOT), (0.0, 0.0, FOOT / 2.0))
    line = box((0.002, WIDTH - 0.03, 0.003), (FRONT - 0.0005, 0.0, 0.052))
    visuals = (
        Visual(mesh_shape("shell", _merged(_shell())), WHITE),
        Visual(mesh_shape("drum", _merged(_drum())), (0.55, 0.57, 0.60)),
        Visual(mesh_shape("rim", _rim()), CHROME),
        *(
            Visual(mesh_shape(f"laundry{i}", cloth), patterned(color, "cloth"), crease=2.0)
            for i, (cloth, color) in enumerate(
                zip(_laundry(), ((0.86, 0.22, 0.30), (0.95, 0.93, 0.88), (0.98, 0.76, 0.20)), strict=True)
            )
        ),
        Visual(mesh_shape("panel", panel), (0.20, 0.32, 0.58)),
        Visual(mesh_shape("soap_drawer", soap), WHITE),
        Visual(mesh_shape("dial", _dial()), CHROME),
        Visual(mesh_shape("keys", keys), WHITE),
        Visual(mesh_shape("display", box((0.006, 0.09, 0.024), (FRONT - 0.003, -0.02, 0.415))), shining((0.15, 0.85, 0.55))),
        Visual(mesh_shape("top", _merged((top,))), (0.20, 0.32, 0.58)),
        Visual(mesh_shape("back", merge([*back, *hoses])), (0.48, 0.50, 0.53)),
        Visual(mesh_shape("feet", plinth), DARK),
        Visual(mesh_shape("kick_line", line), (0.62, 0.64, 0.68)),
    )
    dial = cylinder_shape(0.028, 0.03, (FRONT - 0.016, -0.12, 0.40), (0.0, HALF_PI, 0.0))
    pile = box_shape((0.10, 0.15, 0.06), (-0.045, 0.0, MIDDLE - HOLE + 0.03))
    pipes = tuple(cylinder_shape(0.008, 0.36, (DEPTH / 2.0 + 0.008, y, 0.24), (0.0, 0.0, 0.0)) for y in (-0.15, 0.15))
    solid = tuple(box_shape(size, center) for size, center in (*_shell(), *_drum(), *_feet()))
    return Link("washing_machine", 20.0, visuals, (*solid, dial, pile, *pipes))


def _grip() -> tuple[Mesh, tuple[Shape, ...]]:
    """Return an upright bar on two posts at the right edge of the door."""
    x, y, z = GRIP
    reach, ends = -x - THICK, tuple(side * (BAR_LENGTH / 2.0 - 0.006) for side in (-1, 1))
    bar = rod((x, y, z - BAR_LENGTH / 2.0), (x, y, z + BAR_LENGTH / 2.0), BAR_RADIUS, 10)
    posts = [box((reach, 0.012, 0.012), (x + reach / 2.0, y, e)) for e in ends]
    stays = (box_shape((reach, 0.012, 0.012), (x + reach / 2.0, y, e)) for e in ends)
    return merge([bar, *posts]), (cylinder_shape(BAR_RADIUS, BAR_LENGTH, GRIP), *stays)


def _door_link() -> Link:
    """Return the door; its origin is on the hinge at the height of its middle."""
    profile = [(0.086, -THICK / 2.0), (RADIUS, -THICK / 2.0), (RADIUS, THICK / 2.0 - 0.006), (RADIUS - 0.006, THICK / 2.0)]
    ring = lathe([*profile, (0.086, THICK / 2.0), (0.086, -THICK / 2.0)], 32)
    bowl = [(0.0, -0.030), (0.05, -0.022), (0.087, -0.004), (0.087, 0.004), (0.0, 0.004)]
    place, turn = (-THICK / 2.0, CENTER, 0.0), (0.0, -HALF_PI, 0.0)
    grip, shapes = _grip()
    hinges = merge(box((0.018, 0.016, 0.03), (-0.009, -0.004, z)) for z in (-0.035, 0.035))
    visuals = (
        Visual(mesh_shape("ring", ring.moved(place, turn)), CHROME),
        Visual(mesh_shape("glass", lathe(bowl, 28).moved(place, turn)), GLASS),
        Visual(mesh_shape("grip", grip), DARK),
        Visual(mesh_shape("hinges", hinges), DARK),
    )
    disc = cylinder_shape(RADIUS, THICK, place, turn)
    return Link("door_link", 1.2, visuals, (disc, *shapes), friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    door = Joint("door", "revolute", "washing_machine", "door_link", HINGE, (0.0, 0.0, -1.0), 0.0, 1.6, damping=0.05)
    notes = (
        "front faces -x; hollow; the round door hangs on the left for a viewer in front (at +y) and opens towards -x",
        f"link `door_link` has its origin on the hinge {tuple(round(v, 4) for v in HINGE)} at the height of its middle; "
        f"closed, the disc of radius {RADIUS} spans x -{THICK}..0 there, its middle at y = {CENTER:.3f}",
        f"bar of the grip upright, diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, middle {tuple(round(v, 4) for v in GRIP)} in "
        f"`door_link`; {-GRIP[0] - THICK - BAR_RADIUS:.3f} m free behind it",
        f"drum: x {FRONT + WALL:.3f}..0.1, y -+{HOLE}, z {MIDDLE - HOLE:.3f}..{MIDDLE + HOLE:.3f}, square for collisions, "
        "with clothes at its bottom",
    )
    links = (_body_link(), _door_link())
    return (Model("washing_machine", "objects/washing_machine", "bottom centre", links, (door,), notes),)
