"""Draw docs/images/before_and_after.jpg: twelve tasks late in a demonstration, as one checkout drew them and as this one does.

Usage: python scripts/before_and_after.py --before OLD    OLD is the folder of another checkout

Each checkout plays the demonstrations of seed 0 by itself, so that both show what their users see.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from rlbench_pin.checking.images import contact_sheet

ROOT = Path(__file__).resolve().parents[1]
TASKS = (
    "open_fridge", "take_item_out_of_drawer", "open_microwave", "open_oven", "open_window", "open_washing_machine",
    "lamp_on", "light_bulb_in", "open_wine_bottle", "pick_and_lift", "put_rubbish_in_bin", "take_frame_off_hanger",
)  # fmt: skip
PER_ROW = 4
PLAYER = """
import sys
import numpy as np
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.sim import CameraView, look_at
size = int(sys.argv[2])
side = CameraView(look_at((0.0, 1.5, 1.65), (0.18, 0.0, 0.98)), float(np.radians(42.0)), (size, size), 0.05, 6.0)
behind = CameraView(look_at((-0.72, 0.62, 1.67), (0.30, 0.06, 0.91)), float(np.radians(48.0)), (size, size), 0.05, 6.0)
images = {}
with make_environment(low_dim_config()) as environment:
    for name in sys.argv[3:]:
        task = environment.get_task(name)
        task.set_variation(0)
        task.get_demos(1, live_demos=True, seed=0)
        view = behind if name.startswith(("open_", "take_item")) and "bottle" not in name and "window" not in name else side
        images[name] = task.world.renderer.image(view)
np.savez_compressed(sys.argv[1], **images)
"""
SIZE = 240


def drawn(checkout: Path, folder: Path, name: str) -> dict[str, np.ndarray]:
    """Return an image (h, w, 3) of every task, drawn by the code of a checkout."""
    file = folder / f"{name}.npz"
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    subprocess.run([sys.executable, "-c", PLAYER, str(file), str(SIZE), *TASKS], cwd=checkout, env=environment, check=True)
    with np.load(file) as images:
        return dict(images)


def main() -> None:
    """Draw both and write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, required=True)
    before = parser.parse_args().before.resolve()
    with tempfile.TemporaryDirectory() as name:
        old, new = (drawn(checkout, Path(name), when) for checkout, when in ((before, "before"), (ROOT, "after")))
    sheets = []
    for start in range(0, len(TASKS), PER_ROW):
        part = TASKS[start : start + PER_ROW]
        rows = [[images[task] for task in part] for images in (old, new)]
        title = ("Before and after", "late in a demonstration of seed 0") if start == 0 else ("", "")
        sheets.append(np.asarray(contact_sheet(rows, ["before", "after"], part, *title)))
    sheet = Image.fromarray(np.concatenate(sheets))
    out = ROOT / "docs" / "images" / "before_and_after.jpg"
    sheet.save(out, quality=82, optimize=True)
    print(out, sheet.size)


if __name__ == "__main__":
    main()
