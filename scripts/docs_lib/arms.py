"""The gallery of arms, from the catalogue of arms, their images and docs/results/arms.json."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

from reference_lib.docs import table

from docs_lib.public import ROOT
from rlbench_pin.robot import SUPPORTED_ROBOTS
from rlbench_pin.robot.description import RobotDescription

IMAGES = ROOT / "docs" / "images"
TASKS = ("open_drawer", "push_button", "stack_blocks")
"""Tasks that every arm is shown with."""
ENOUGH = 0.8
"""Share of first tries that counts as usable."""
HEAD = """# Arms gallery

Five arms come with the package: `Environment(robot_setup="ur5e")` loads one. [Arms](arms.md) explains their use and how to add
your own; [arms and tasks](results/arms.md) has the success of every arm in every task.
"""


def arm_page(source: Path) -> dict[str, str]:
    """Return file -> text of the page of all arms."""
    measured = json.loads((ROOT / "docs" / "results" / "arms.json").read_text(encoding="utf-8"))["arms"]
    parts = [HEAD]
    for name, arm in SUPPORTED_ROBOTS.items():
        parts.append(f"## {name}\n\n{table(('', ''), list(facts(arm)))}\n")
        cells = measured.get(name, {})
        if cells:
            usable = sum(cell["rate"] >= ENOUGH for cell in cells.values())
            parts.append(f"At least {100 * ENOUGH:.0f} % of first demonstrations succeed in {usable} of {len(cells)} tasks.\n")
        sheets = [IMAGES / "arms" / f"{name}_{task}.jpg" for task in TASKS]
        sheets = [file if file.is_file() else IMAGES / "sheets" / f"{task}.jpg" for file, task in zip(sheets, TASKS)]
        links = [os.path.relpath(file, source) for file in sheets]
        parts.append(table(TASKS, [[f"[![{name}, {task}]({link})]({link})" for task, link in zip(TASKS, links)]]) + "\n")
    return {"arm_gallery.md": "\n".join(parts)}


def facts(arm: RobotDescription) -> Iterator[tuple[str, str]]:
    """Yield the rows about an arm."""
    yield "Joints", f"{len(arm.arm_joints)}: {', '.join(f'`{joint}`' for joint in arm.arm_joints)}"
    yield "Home [rad]", ", ".join(f"{q:g}" for q in arm.home)
    yield "Base in the world [m]", ", ".join(f"{x:g}" for x in arm.base_pose[:3])
    yield "Gripper", f"opens to {2000 * arm.gripper_open:.0f} mm between the pads, {arm.gripper_force:g} N for each finger"
    yield "Acceleration limits [rad/s²]", ", ".join(f"{a:g}" for a in arm.acceleration)
    yield "Largest speed of the tip", f"{arm.linear_speed:g} m/s, {arm.angular_speed:g} rad/s"
    yield "Joint stiffness [N m/rad]", ", ".join(f"{k:g}" for k in arm.joint_stiffness)
