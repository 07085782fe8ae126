"""`rlbench-pin view TASK`: draw the events of a demonstration, or serve a live page."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path

import tyro

from rlbench_pin.cli.options import Files, MaybePath, Viewed, check_at_least, check_file, write_whole
from rlbench_pin.cli.pages import PageOptions, check_port, live_module, live_page, wait_for_end
from rlbench_pin.errors import TaskEnvironmentError

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
"""Suffix of the file name -> format of the image."""


@dataclass(frozen=True)
class View:
    """Draw a contact sheet of a demonstration: reset, grasp, half way, success, and 1 s later. The images are from a camera aimed
    at the task, the five observation cameras and `clear_robot_side`. With `--live`, serve a page with episodes of a task, or with
    the stored demonstrations of a dataset.
    """

    task: tyro.conf.Positional[Viewed]
    """Task name, as `rlbench-pin list` prints it, or a task file; with `--live` also the folder of a dataset."""
    variation: int = 0
    """Variation of the task."""
    seed: int = 0
    """Seed of the episode."""
    out: MaybePath = None
    """PNG or JPEG file to write. Default: `out/view/<task>.png`."""
    size: int = 384
    """Side of the task view [px]; the other images have about half of it."""
    page: tyro.conf.OmitArgPrefixes[PageOptions] = field(default_factory=PageOptions)
    """Serve a page instead of drawing an image."""
    task_file: Files = ()
    """With a dataset: your own task files for tasks that are not installed; they replace those in the dataset."""
    trust_task_files: bool = False
    """Run the task files in the dataset, for tasks that are not installed. Read them first."""

    def run(self) -> int:
        """Draw the image and print its path, or serve a page until Ctrl-C."""
        from rlbench_pin.checking.sheets import demo_sheet
        from rlbench_pin.tasks import find_task

        check_at_least(self, variation=0, seed=0, size=1)
        check_port(self.page)
        if self.page.live:
            return self._live()
        task = find_task(self.task)
        out = self.out or Path("out/view") / f"{task.get_name()}.png"
        if out.suffix.lower() not in FORMATS:
            raise TaskEnvironmentError(f"--out is '{out}'; the name of an image must end in one of {', '.join(FORMATS)}.")
        check_file(out)
        sheet, _ = demo_sheet(task, self.seed, self.variation, size=self.size)
        image = io.BytesIO()
        sheet.save(image, format=FORMATS[out.suffix.lower()])
        print(write_whole(out, image.getvalue()))
        return 0

    def _live(self) -> int:
        from rlbench_pin.tasks import find_task, own_tasks

        if self.out is not None:
            raise TaskEnvironmentError("--out names an image, and --live shows a page. Leave one of them out.")
        live = live_module()
        if Path(self.task).is_dir():
            own, title = own_tasks(self.task_file), self.task
            page = live_page(lambda server: live.DatasetView(server, self.task, own, self.trust_task_files), title, self.page)
        else:
            task = find_task(self.task)
            page = live_page(lambda server: live.TaskView(server, task, self.seed, self.variation), task.get_name(), self.page)
        with page:
            wait_for_end()
        return 0
