"""`rlbench-pin view TASK`: one picture of a task, as the five cameras and the clear view see a demonstration, or a page."""

from __future__ import annotations

import io
from pathlib import Path

from rlbench_pin.checking.images import demo_sheet
from rlbench_pin.cli.arguments import view as arguments
from rlbench_pin.cli.process.files import check_file, write_whole
from rlbench_pin.cli.process.pages import check_port, live_module, serve
from rlbench_pin.cli.process.words import check_at_least
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.tasks import find_task, own_tasks

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
"""End of a file name -> how the picture is written."""


class View(arguments.View):
    """The work of `rlbench-pin view`."""

    def run(self) -> int:
        """Draw, and print where the picture is; or serve a page until Ctrl-C."""
        check_at_least(self, variation=0, seed=0, size=1)
        check_port(self.page)
        if self.page.live:
            return self._live()
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

    def _live(self) -> int:
        if self.out is not None:
            raise TaskEnvironmentError("--out names a picture, and --live shows a page. Leave one of them out.")
        opened, port = live_module().LiveView, self.page.port
        if Path(self.task).is_dir():
            own = own_tasks(self.task_file)
            return serve(opened.of_dataset(Path(self.task), own, self.trust_task_files, port), self.page.browser)
        return serve(opened.of_task(find_task(self.task), self.seed, self.variation, port), self.page.browser)
