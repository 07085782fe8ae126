"""The texts of a task in which nothing is yet."""

from __future__ import annotations

from string import Template

from rlbench_pin.tasks import camel_case

_SCENE = """\
format = 2                                  # lengths [m], angles [rad], heights from the table top

[placement]
footprint = [0.3, 0.3]                      # the patch of table that the task needs
"""
_PYTHON = Template('''\
"""$title."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Task


class $cls(Task):
    """$title."""

    def init_task(self) -> None:
        """Say what success is."""
        self.register_success_conditions([])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences."""
        return ["$title."]
''')


def texts_of_new_task(name: str) -> tuple[str, str]:
    """Return the scene and the Python of an empty task."""
    title = name.replace("_", " ").capitalize()
    return _SCENE, _PYTHON.substitute(cls=camel_case(name), title=title)
