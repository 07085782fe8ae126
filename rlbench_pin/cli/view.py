"""`rlbench-pin view TASK`: one picture of a task, as the five cameras see a demonstration."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import tyro

from rlbench_pin.checking.pages.demo_sheet import demo_sheet
from rlbench_pin.cli.process.files import check_file, write_whole
from rlbench_pin.cli.process.words import TaskName, check_at_least
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.tasks import find_task

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
"""End of a file name -> how the picture is written."""


@dataclass(frozen=True)
class View:
    """Draw a contact sheet: the five cameras at the reset and at four moments of a demonstration."""

    task: tyro.conf.Positional[TaskName]
    """Task name, as `rlbench-pin list` prints it, or a task file."""
    variation: int = 0
    """Variation of the task."""
    seed: int = 0
    """Seed of the episode."""
    out: Path | None = None
    """PNG or JPEG to write; `out/view/<task>.png` by default."""
    size: int = 256
    """Side of each picture [px]."""

    def run(self) -> int:
        """Draw, and print where the picture is."""
        check_at_least(self, variation=0, seed=0, size=1)
        task = find_task(self.task)
        out = self.out or Path("out/view") / f"{task.get_name()}.png"
        if out.suffix.lower() not in FORMATS:
            raise TaskEnvironmentError(f"--out is '{out}'; the name of a picture must end in one of {', '.join(FORMATS)}.")
        check_file(out)
        sheet, _ = demo_sheet(task, self.seed, self.variation, size=self.size)
        picture = io.BytesIO()
        sheet.save(picture, format=FORMATS[out.suffix.lower()])
        print(write_whole(out, picture.getvalue()))
        return 0
