"""Writes `CATALOGUE.md` and `LICENSES.md` from the models."""

from __future__ import annotations

from pathlib import Path

from assets_lib.files import number, numbers, write_text
from assets_lib.urdf import Model

HEAD = """# Catalogue of assets

Written by `scripts/build_assets.py`; do not edit. Lengths in [m], angles in [rad], masses in [kg]. An asset is named
`objects/<name>/<name>.urdf` in a scene file. Link frames at joint value 0 are given in the frame of the object.
PyBullet adds a margin of 1 mm around collision meshes (chicken, steak, rubbish, bin walls, arm links), so that they rest 1 mm
higher than listed here. Load with `URDF_USE_IMPLICIT_CYLINDER`, so that cylinders are exact, as in Coal.
PyBullet aligns inertial frames with the principal axes: convert between its base poses and link frames with the whole pose.
Every visual part is a separate `<visual>` with its own colour; a new colour of a link applies to all its visual parts.
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

`robots/panda/panda.urdf` - origin: foot of the base (`panda_link0`), arm extends along +x; SRDF in the same folder.
Tip frame `panda_hand_tcp`: z out of the gripper, fingers open along its y. Fingers `panda_finger_joint1` (left, -y) and
`panda_finger_joint2` (right, +y), each 0..0.04.
Pads about 0.018 x 0.018, ending 0.0095 beyond the tip frame; body of the gripper 0.20 (y) x 0.064 (x).

## ur5e

`robots/ur5e/ur5e.urdf` - origin: foot of the base (`ur5e_base_link`), arm extends along +x at 0; SRDF in the same folder.
Universal Robots UR5e with a Robotiq 2F-85, its coupling 0.0139 high. Tip frame `ur5e_tip`: z out of the gripper, y from the left
finger to the right one. Drives `ur5e_finger_joint` (left, -y) and `ur5e_right_outer_knuckle_joint` (right, +y), each 0..0.8,
0 open, 0.8 closed. On each side the inner knuckle follows by `<mimic>` with the same angle, the inner finger with the opposite
angle, so that the pads stay parallel. Pads 0.022 x 0.0375 on the inner fingers, 0.0845 apart when open. They move along z: their
ends are at the height of the tip frame when open, 0.0091 beyond it at 0.3, 0.0126 at 0.5, 0.0140 at 0.7 and 0.0138 when closed.
Body of the gripper 0.085 (y) x 0.075 (x), the whole linkage 0.15 (y) when open.

## xarm7

`robots/xarm7/xarm7.urdf` - origin: foot of the base (`xarm7_link_base`), arm extends along +x at 0; SRDF in the same folder.
UFACTORY xArm7 with our gripper (see below) and the prefix `xarm7`.

## jaco

`robots/jaco/jaco.urdf` - origin: foot of the base (`jaco_base`), arm extends along +x at joint 1 = 0; SRDF in the same folder.
Kinova Jaco j2s6s200 with our gripper (see below) in place of its hand, and the prefix `jaco`. Joints 1, 4 and 6 are continuous.
The arm is upright with joints 2, 3 and 5 at 3.1416, the middle of their ranges.

## iiwa

`robots/iiwa/iiwa.urdf` - origin: foot of the base (`iiwa_link_0`), arm upright at 0, extends along +x as joint 2 increases; SRDF
in the same folder. KUKA LBR iiwa 7 R800 with our gripper (see below) and the prefix `iiwa`.

## Our gripper

For xarm7, jaco and iiwa; `<arm>` is the name of the arm. Link `<arm>_hand` is on the flange, 0.166 (y) x 0.059 (x). Tip frame
`<arm>_tip`: z out of the gripper, y from the left finger to the right one. Fingers `<arm>_finger_joint1` (left, -y of the tip
frame) and `<arm>_finger_joint2` (right, +y), each 0..0.04. Pads about 0.018 x 0.018, ending 0.0095 beyond the tip frame, which is
0.1034 above the flange; all values are those of the Panda.
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
| robots/ur5e | MIT (text in `robots/ur5e/LICENSE`) | the package airo-models 0.0.12, (c) Andreas Verleysen, UR5e and Robotiq \
2F-85; changed by us: meshes decimated, recoloured and hulled, links joined, ROS tags removed, masses and limits of the makers |
| robots/xarm7 | BSD-3-Clause (text in `robots/xarm7/LICENSE`); gripper MIT | xarm_ros2, (c) UFACTORY, Inc., taken from the \
package example-robot-data; changed by us: meshes decimated, recoloured and hulled, ROS tags removed; gripper ours |
| robots/jaco | BSD-3-Clause (text in `robots/jaco/LICENSE`); gripper MIT | kinova-ros, (c) Kinova Robotics inc., taken from the \
package example-robot-data; changed by us: meshes decimated, recoloured and hulled, hand removed, ROS tags removed; gripper ours |
| robots/iiwa | MIT | ours; measures and limits of the maker's data sheet |
"""


def write_licences(models: tuple[Model, ...], assets: Path) -> None:
    """Write `LICENSES.md` below `assets`."""
    lines = [f"| {m.folder if m.folder != 'room' else 'room/' + m.name} | MIT | ours |" for m in models]
    lines.append("| room/wood.png, room/tiles.png, room/wall.png, textures/*.png, patterns/*.png | MIT | ours |")
    write_text(assets / "LICENSES.md", LICENCES + "\n".join(lines) + "\n")
