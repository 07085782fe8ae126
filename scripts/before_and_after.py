"""Draw docs/images/before_and_after.jpg: the end of demonstrations of twelve tasks, drawn by another checkout and by this one.

Usage: python scripts/before_and_after.py --before OLD    OLD is the folder of another checkout

Each checkout plays the demonstrations of seed 0. This checkout selects the cameras; the arm is hidden unless it holds an
object.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image

from rlbench_pin.checking.sheets import Moment, contact_sheet, demo_moments
from rlbench_pin.tasks import find_task

ROOT = Path(__file__).resolve().parents[1]
TASKS = (
    "open_fridge", "take_item_out_of_drawer", "open_microwave", "open_oven", "open_window", "open_washing_machine",
    "lamp_on", "light_bulb_in", "open_wine_bottle", "pick_and_lift", "put_rubbish_in_bin", "take_frame_off_hanger",
)  # fmt: skip
PER_ROW = 4
PLAYER = """
import json, sys
import numpy as np
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.sim import CameraView
size, images = int(sys.argv[2]), {}
for name, (pose, fov, hides_arm) in json.loads(sys.argv[3]).items():
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        task.set_variation(0)
        task.get_demos(1, live_demos=True, seed=0)
        if hides_arm:
            task.world.robot.model.set_base_pose([0.0, 0.0, -10.0, 0.0, 0.0, 0.0, 1.0])
        view = CameraView(np.array(pose), fov, (size, size), 0.05, 6.0)
        images[name] = task.world.render(view, depth=False, mask=False, shadows=True).rgb
np.savez_compressed(sys.argv[1], **images)
"""
SIZE, FINER = 240, 3


def before(checkout: Path, moments: Mapping[str, Moment]) -> dict[str, Image.Image]:
    """Return an image of the end of each task's demonstration, drawn by the code of another checkout from the same cameras."""
    cameras = {name: (m.view.pose.tolist(), m.view.fov, m.arm_hidden) for name, m in moments.items()}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "before.npz"
        words = [sys.executable, "-c", PLAYER, str(file), str(FINER * SIZE), json.dumps(cameras)]
        subprocess.run(words, cwd=checkout, env={**os.environ, "PYTHONPATH": str(checkout)}, check=True)
        with np.load(file) as images:
            return {name: Image.fromarray(image).resize((SIZE, SIZE), Image.Resampling.LANCZOS) for name, image in images.items()}


def main() -> None:
    """Draw both and write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, required=True)
    checkout = parser.parse_args().before.resolve()
    moments = {name: demo_moments(find_task(name), 0, size=SIZE)[1][-1] for name in TASKS}
    old = before(checkout, moments)
    sheets = []
    for start in range(0, len(TASKS), PER_ROW):
        part = TASKS[start : start + PER_ROW]
        rows = [
            [np.asarray(old[name]) for name in part],
            [np.asarray(moments[name].task if moments[name].arm_hidden else moments[name].with_arm) for name in part],
        ]
        title = ("Before and after", "at the end of a demonstration of seed 0, from the same cameras") if start == 0 else ("", "")
        sheets.append(np.asarray(contact_sheet(rows, ["before", "after"], part, *title)))
    sheet = Image.fromarray(np.concatenate(sheets))
    out = ROOT / "docs" / "images" / "before_and_after.jpg"
    sheet.save(out, quality=82, optimize=True)
    print(out, sheet.size)


if __name__ == "__main__":
    main()
