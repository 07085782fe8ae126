"""The tables of `CATALOGUE.md`, written from the models."""

from __future__ import annotations

from pathlib import Path

from assets_lib.files import number, numbers, write_text
from assets_lib.urdf import Model

HEAD = """# Catalogue of assets

Written by `scripts/build_assets.py`; do not edit. Lengths in [m], angles in [rad], masses in [kg]. An asset is named
`objects/<name>/<name>.urdf` in a scene file. Link frames at joint value 0 are given in the frame of the object.
PyBullet puts a skin of 1 mm around collision meshes (chicken, steak, rubbish, bin walls, arm links): they rest 1 mm higher
than said here. Load with `URDF_USE_IMPLICIT_CYLINDER`, so that cylinders stay cylinders there as they are in Coal.
PyBullet turns inertial frames along the principal axes: convert between its base poses and link frames with the whole pose.
Every visual part is an own `<visual>` with an own colour; recolouring a link recolours all of its visual parts.
"""


def _table(model: Model) -> list[str]:
    lines = ["", f"## {model.name}", "", f"`{model.folder}/{model.name}.urdf` - origin: {model.origin}.", ""]
    lines += ["| link | mass | friction | collision parts | visual parts |", "|---|---|---|---|---|"]
    for link in model.links:
        seen = ", ".join(f"{v.shape.name or v.shape.kind} ({numbers(v.color, 2)})" for v in link.visuals)
        lines.append(f"| `{link.name}` | {number(link.mass)} | {number(link.friction)} | {len(link.collisions)} | {seen} |")
    if model.joints:
        lines += ["", "| joint | type | child link | frame of the child at 0 | axis | range | damping |"]
        lines.append("|---|---|---|---|---|---|---|")
    for joint in model.joints:
        span = f"{number(joint.lower)}..{number(joint.upper)}"
        place, axis = f"({numbers(joint.xyz, 5)})", f"({numbers(joint.axis)})"
        lines.append(f"| `{joint.name}` | {joint.kind} | `{joint.child}` | {place} | {axis} | {span} | {number(joint.damping)} |")
    if model.notes:
        lines += ["", *(f"- {note}" for note in model.notes)]
    return lines


ROBOT = """
## panda

`robots/panda/panda.urdf` - origin: foot of the base (`panda_link0`), arm reaching along +x; SRDF beside it.
Tip frame `panda_hand_tcp`: z out of the hand, fingers open along its y. Fingers `panda_finger_joint1` (left, -y) and
`panda_finger_joint2` (right, +y), each 0..0.04.
Pads about 0.018 x 0.018, ending 0.0095 beyond the tip frame; hand body 0.20 (y) x 0.064 (x).
"""


def write_catalogue(models: tuple[Model, ...], assets: Path) -> None:
    """Write `CATALOGUE.md` below `assets`."""
    text = "\n".join([HEAD.strip(), ROBOT.rstrip(), *(line for model in models for line in _table(model))])
    write_text(assets / "CATALOGUE.md", text + "\n")


LICENCES = """# Licences of the assets

Written by `scripts/build_assets.py`. "MIT" is the licence of this repository: shapes, textures and numbers are our own and come
from formulas in `scripts/assets_lib`.

| asset | licence | source |
|---|---|---|
| robots/panda | Apache-2.0 (text in `robots/panda/LICENSE`) | franka_description, (c) Franka Emika GmbH, taken from the package \
example-robot-data; changed by us: meshes decimated, recoloured and hulled, mimic and ROS tags removed from the URDF |
"""


def write_licences(models: tuple[Model, ...], assets: Path) -> None:
    """Write `LICENSES.md` below `assets`."""
    lines = [f"| {m.folder if m.folder != 'room' else 'room/' + m.name} | MIT | ours |" for m in models]
    lines.append("| room/wood.png, room/tiles.png, room/wall.png, textures/*.png, patterns/*.png | MIT | ours |")
    write_text(assets / "LICENSES.md", LICENCES + "\n".join(lines) + "\n")
