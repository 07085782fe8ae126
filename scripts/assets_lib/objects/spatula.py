"""A spatula, the block under its handle, a light cube and a low stop."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, hull_of, merge
from assets_lib.urdf import Link, Model, Vec3, Visual, box_shape, mesh_shape, metal, patterned, plastic

BLADE, EDGE, EDGE_TALL = (0.09, 0.07, 0.002), 0.012, 0.001
"""Length, width, thickness of the blade; length and thickness of its front edge [m]."""
LIP = (0.07, 0.003, 0.007)
HANDLE, RISE = (0.15, 0.02, 0.02), float(np.pi / 6.0)
"""Length, width, height of the handle, and its angle to the blade [rad]."""
CUBE, BEVEL, MARGIN = 0.025, 0.003, 0.001
"""Side and bevel of the cube; the engine puts a margin round every mesh [m]."""
BLOCK: Vec3 = (0.03, 0.06, 0.08)
STOP: Vec3 = (0.012, 0.07, 0.012)
STEEL = metal((0.72, 0.74, 0.77))
COS, SIN = float(np.cos(RISE)), float(np.sin(RISE))


def on_handle(along: float, above: float = 0.0) -> Vec3:
    """Return the place at a distance along the axis of the handle from the rear of the blade, and above it [m]."""
    return (-BLADE[0] / 2.0 - along * COS + above * SIN, 0.0, HANDLE[2] / 2.0 + along * SIN + above * COS)


def _spatula() -> Model:
    x, y, z = BLADE
    flat = box_shape((x - EDGE, y, z), (-EDGE / 2.0, 0.0, z / 2.0))
    edge = box_shape((EDGE, y, EDGE_TALL), ((x - EDGE) / 2.0, 0.0, EDGE_TALL / 2.0))
    lips = tuple(box_shape(LIP, (-x / 2.0 + LIP[0] / 2.0, s * (y - LIP[1]) / 2.0, LIP[2] / 2.0)) for s in (-1.0, 1.0))
    tilt = (0.0, RISE, 0.0)
    grip = box_shape(HANDLE, on_handle(HANDLE[0] / 2.0), tilt)
    outline = [(x / 2.0 - EDGE, z), (x / 2.0, 0.0003), (x / 2.0, 0.0), (x / 2.0 - EDGE, 0.0)]
    wedge = hull_of(np.array([(u, v, w) for v in (-y / 2.0, y / 2.0) for u, w in outline]))
    slots = merge(box_shape((0.045, 0.005, 0.0006), (-0.006, v, z)).mesh() for v in (-0.018, 0.0, 0.018))
    visuals = (
        Visual(
            mesh_shape("blade", merge([flat.mesh(), wedge, *(lip.mesh() for lip in lips)])),
            patterned(STEEL, "brushed"),
            crease=0.1,
        ),
        Visual(mesh_shape("slots", slots), (0.20, 0.21, 0.22)),
        Visual(mesh_shape("neck", _neck()), patterned(STEEL, "brushed"), crease=0.1),
        Visual(mesh_shape("grip", _grip()), plastic((0.13, 0.14, 0.16)), crease=0.1),
        Visual(mesh_shape("rivets", _rivets()), STEEL, crease=0.1),
    )
    link = Link("spatula", 0.08, visuals, (flat, edge, *lips, grip), friction=0.6)
    middle = on_handle(0.1)
    notes = (
        f"blade {x} x {y} x {z}, flat on the table, its bevelled edge at x = {x / 2.0}; lips along both sides",
        f"handle towards -x, rising by {RISE:.4f} rad, {HANDLE[1]} thick; its axis passes ({middle[0]:.4f}, 0, {middle[2]:.4f})",
        "the end of the handle lies on `spatula_block`",
    )
    return Model("spatula", "objects/spatula", "bottom centre of the blade", (link,), notes=notes)


def _neck() -> Mesh:
    """Return the shaft below the grip, and the tongue by which it is welded to the rear of the blade."""
    shaft = bevelled_box((0.042, 0.014, 0.009)).moved(on_handle(0.027), (0.0, RISE, 0.0))
    rear, low, high = -BLADE[0] / 2.0, 0.0004, BLADE[2] + 0.0016
    top = [on_handle(0.012, above) for above in (-0.0045, 0.0045)]
    bend = [(rear + 0.001, 0.013, low), (rear + 0.001, 0.013, high), (rear + 0.012, 0.012, high)]
    pad = [(rear + 0.001, 0.013), (rear + 0.022, 0.010), (rear + 0.030, 0.004)]
    sides = (-1.0, 1.0)
    bent = hull_of(np.array([(x, s * y, z) for x, y, z in [*bend, *((x, 0.007, z) for x, _, z in top)] for s in sides]))
    return merge([shaft, bent, hull_of(np.array([(x, s * y, z) for x, y in pad for z in (low, high) for s in sides]))])


def _grip() -> Mesh:
    length = HANDLE[0] - 0.035
    return bevelled_box((length, HANDLE[1], HANDLE[2])).moved(on_handle(HANDLE[0] - length / 2.0), (0.0, RISE, 0.0))


def _rivets() -> Mesh:
    size = (0.006, HANDLE[1] + 0.001, 0.006)
    return merge(bevelled_box(size).moved(on_handle(along), (0.0, RISE, 0.0)) for along in (0.055, 0.135))


def _cube() -> Model:
    """Return a light cube, the edges of which are bevelled for the engine as well, so that a blade gets under it."""
    side = (CUBE, CUBE, CUBE)
    core = CUBE - 2.0 * MARGIN
    hull = mesh_shape("hull", bevelled_box((core, core, core), bevel=BEVEL))
    visual = Visual(mesh_shape("cube", bevelled_box(side, bevel=BEVEL)), plastic((0.86, 0.42, 0.12)), crease=0.1)
    link = Link("scoop_cube", 0.01, (visual,), (hull,), friction=0.4)
    return Model("scoop_cube", "objects/scoop_cube", "centre", (link,), notes=(f"rests with its origin at {CUBE / 2.0} m",))


def _block() -> Model:
    """Return a block whose upper side slopes like the handle of the spatula."""
    x, y, z = BLOCK
    drop = x * SIN / COS
    corners = np.array([(u * x / 2.0, v * y / 2.0, w) for u, h in ((-1, z), (1, z - drop)) for v in (-1, 1) for w in (0.0, h)])
    top = box_shape((x / COS, y, 0.01), (-0.005 * SIN, 0.0, z - drop / 2.0 - 0.005 * COS), (0.0, RISE, 0.0))
    base = box_shape((x - 0.008, y, z - drop - 0.004), (-0.002, 0.0, (z - drop - 0.004) / 2.0))
    link = Link(
        "spatula_block",
        0.4,
        (Visual(mesh_shape("block", hull_of(corners)), patterned((0.58, 0.40, 0.24), "wood"), crease=0.1),),
        (top, base),
        friction=1.2,
    )
    notes = (f"its upper side falls from {z} at x = {-x / 2.0} by {RISE:.4f} rad towards +x",)
    return Model("spatula_block", "objects/spatula_block", "bottom centre", (link,), notes=notes)


def _stop() -> Model:
    visual = Visual(
        mesh_shape("rail", bevelled_box(STOP, (0.0, 0.0, STOP[2] / 2.0))), patterned((0.58, 0.40, 0.24), "wood"), crease=0.1
    )
    link = Link("scoop_stop", 0.2, (visual,), (box_shape(STOP, (0.0, 0.0, STOP[2] / 2.0)),), friction=0.3)
    return Model("scoop_stop", "objects/scoop_stop", "bottom centre", (link,), notes=("long along y",))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_spatula(), _cube(), _block(), _stop())
