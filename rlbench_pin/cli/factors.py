"""`rlbench-pin factors`: list the factors of generalisation and their levels, and draw images of them."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from rlbench_pin.cli.options import AnyTasks, MaybePath, Size, check_folder
from rlbench_pin.observation import CAMERAS

if TYPE_CHECKING:
    import numpy as np

    from rlbench_pin.environment.factors import Factor

CameraName = Annotated[str, tyro.conf.arg(metavar=f"{{{','.join(CAMERAS)}}}")]
"""A camera."""
WIDTH = 110
"""Columns of the list."""


@dataclass(frozen=True)
class ListFactors:
    """List the factors of generalisation: what each changes, and the numbers of its levels.

    With tasks, it prints the factors that cannot change each task, with the reason. `rlbench-pin factors open_drawer --images
    out/factors` writes an image of each factor: without the factor, then levels 1, 2 and 3.
    """

    tasks: tyro.conf.Positional[AnyTasks] = ()
    """Tasks to list factors for."""
    images: MaybePath = None
    """Folder for an image of each visible factor, with the first task."""
    camera: CameraName = "front"
    """Camera of these images."""
    image_size: Size = (256, 256)
    """Width and height of one level in these images [px]."""
    seed: int = 0
    """Seed of the episode in these images."""
    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Print the list, and draw the images."""
        from rlbench_pin.cli.list_tasks import split_names
        from rlbench_pin.environment.factors import factor_catalogue

        tasks = split_names(self.tasks)
        missing = {name: _missing(name) for name in tasks}
        if self.json:
            factors = [asdict(factor) for factor in factor_catalogue().values()]
            print(json.dumps({"factors": factors, "not_applicable": missing}, indent=1))
        elif tasks:
            for name, reasons in missing.items():
                print(f"{name}: all factors" if not reasons else f"{name}: all factors except")
                for factor, reason in reasons.items():
                    print(f"  {factor}: {reason}")
        else:
            print("\n".join(_lines(factor_catalogue().values())))
        if self.images is not None:
            check_folder(self.images)
            for path in self._draw(tasks[0] if tasks else "open_drawer", self.images):
                print(f"  image  {path}")
        return 0

    def _draw(self, task: str, folder: Path) -> Iterator[Path]:
        """Draw the levels of each factor that changes an image side by side, and yield the files."""
        import numpy as np

        from rlbench_pin.datasets.formats.rlbench import write_png
        from rlbench_pin.environment.environment import Environment
        from rlbench_pin.environment.factors import factor_catalogue
        from rlbench_pin.environment.presets import image_config, joint_position_mode

        config = image_config(self.image_size, (self.camera,), depth=False, mask=False)
        with Environment(joint_position_mode(), obs_config=config, seed=0) as environment:
            running = environment.get_task(task)
            for factor in factor_catalogue().values():
                if factor.why_not(running.task):
                    continue
                seen: list[np.ndarray] = []
                for level in range(len(factor.levels) + 1):
                    running.set_factors({factor.name: level})
                    _, observation = running.reset(seed=self.seed, variation=0)
                    seen.append(getattr(observation, f"{self.camera}_rgb"))
                if any(not np.array_equal(seen[0], image) for image in seen[1:]):
                    path = folder / f"{factor.name}.png"
                    write_png(path, np.concatenate(seen, axis=1))
                    yield path


def _missing(task: str) -> dict[str, str]:
    """Return the factors that cannot change a task, each with the reason."""
    from rlbench_pin.environment.environment import Environment
    from rlbench_pin.environment.factors import factor_catalogue
    from rlbench_pin.environment.presets import joint_position_mode, low_dim_config

    with Environment(joint_position_mode(), obs_config=low_dim_config(), seed=0) as environment:
        running = environment.get_task(task).task
        reasons = {name: factor.why_not(running) for name, factor in factor_catalogue().items()}
    return {name: reason for name, reason in reasons.items() if reason}


def _lines(factors: Any) -> Iterator[str]:
    group = ""
    for factor in factors:
        if factor.group != group:
            yield f"{'' if not group else chr(10)}{factor.group}"
            group = factor.group
        yield from textwrap.wrap(f"{factor.name}: {factor.changes}", WIDTH, initial_indent="  ", subsequent_indent="    ")
        for level in factor.level_names if factor.levels[0] else ():
            yield f"    {level}: {_numbers(factor, level)}"


def _numbers(factor: Factor, level: str) -> str:
    numbers = factor.numbers(int(level) if level.isdigit() else "colosseum")
    spans = {key: value if isinstance(value, tuple) else (value, value) for key, value in numbers.items()}
    return ", ".join(f"{key} {low:g}" + (f" to {high:g}" if high > low else "") for key, (low, high) in spans.items())
