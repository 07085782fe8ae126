"""`rlbench-pin view TASK`: one picture of a task, as the five cameras see a demonstration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from rlbench_pin.checking.pages.demo_sheet import demo_sheet
from rlbench_pin.tasks import find_task


@dataclass(frozen=True)
class View:
    """Draw a contact sheet: the five cameras at the reset and at four moments of a demonstration."""

    task: tyro.conf.Positional[str]
    """Task name, as `rlbench-pin list` prints it, or a task file."""
    variation: int = 0
    """Variation of the task."""
    seed: int = 0
    """Seed of the episode."""
    out: Path | None = None
    """PNG to write; `out/view/<task>.png` by default."""
    size: int = 256
    """Side of each picture [px]."""

    def run(self) -> int:
        """Draw, and print where the picture is."""
        sheet, name = demo_sheet(find_task(self.task), self.seed, self.variation, size=self.size)
        out = self.out or Path("out/view") / f"{name}.png"
        out.parent.mkdir(parents=True, exist_ok=True)
        sheet.save(out)
        print(out)
        return 0
