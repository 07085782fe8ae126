"""`rlbench-pin new NAME`: write a pair of commented task files that passes `rlbench-pin check` unchanged."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import Annotated

import tyro

from rlbench_pin.cli.options import write_whole
from rlbench_pin.errors import StorageError, TaskEnvironmentError, storing

TASK = Template('''\
"""$title. (One sentence: the goal.)"""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, SpawnBoundary, Task, TipInside


class $cls(Task):
    """Describe the variations and the success condition. Here: the tip must be inside the ball; its colour is the variation."""

    solved_by_chance = True  # random actions can reach a ball in the air; delete this line if that is a fault of your task

    def init_task(self) -> None:
        """Called once: look up elements by their names in $name.toml, register graspable objects and success conditions."""
        self.ball = self.world.body("ball")
        self.place = SpawnBoundary([self.world.region("air")])
        # self.register_graspable_objects(["ball"])
        self.register_success_conditions([TipInside(self.robot, self.world.sensor("goal"))])

    def variation_count(self) -> int:
        """Return the number of goals; delete this method if there is only one."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Called for every episode: draw all random values from `rng`, return instructions that all describe the goal."""
        name, rgb = COLORS[variation]
        self.ball.set_color(rgb)
        self.place.clear()
        self.place.sample(self.ball, rng)
        return [f"Touch the {name} ball.", f"Bring the gripper to the {name} ball."]
''')
SCENE = Template("""\
# Lengths [m], angles [rad]; a pose is [x, y, z] or [x, y, z, yaw] or [x, y, z, qx, qy, qz, qw] in the frame of `parent`;
# rpy = [roll, pitch, yaw] adds a rotation to a pose of three numbers.
format = 2

[placement]                                 # pose of the task root; all poses below are in its frame
pose = [0.25, 0.0, 0.0]                     # in the middle of the placement area; heights are above the table top
static = true                               # false: the root is placed at random in every episode
yaw = [0.0, 0.0]                            # bounds of its random yaw

[[body]]                                    # assets: rlbench_pin/assets/CATALOGUE.md; your own: asset = "./object.urdf"
name = "ball"
asset = "objects/ball_marker/ball_marker.urdf"
pose = [0.0, 0.0, 0.12]
fixed = true                                # false: it moves under gravity

[[region]]                                  # a box to place objects in
name = "air"
pose = [0.05, 0.0, 0.12]
size = [0.35, 0.5, 0.1]

[[sensor]]                                  # a volume that detects bodies; this one moves with the ball
name = "goal"
parent = "ball"
shape = "sphere"
size = [0.05]

[[waypoint]]                                # the demonstration visits waypoint0, waypoint1, ... with the tip
name = "waypoint0"
parent = "ball"
rpy = [3.1415927, 0.0, 0.0]                 # gripper pointing down
symmetry = 4                                # grasp symmetry: the gripper may also be rotated by 90, 180 or 270 degrees
# path = "straight"                         # or "curve"; the default is "plan"
# ignore_collisions = true                  # for motions that touch objects
# gripper = "close"                         # after arriving: "open", "close" or an opening 0.0 to 1.0
""")


@dataclass(frozen=True)
class New:
    """Write two commented files, NAME.py and NAME.toml: a reach task that passes `rlbench-pin check --task-file NAME.py`."""

    name: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="NAME")]]
    """Name of the task in snake case."""
    out: Path = Path()
    """Folder to write to; `rlbench_pin/tasks/library` makes it a task of the package."""

    def run(self) -> int:
        """Write both files, and print the next step. Existing files are never overwritten."""
        from rlbench_pin.tasks import camel_case, task_names
        from rlbench_pin.tasks.registry import name_fault

        if fault := name_fault(self.name):
            raise TaskEnvironmentError(f"'{self.name}': {fault}")
        if self.name in task_names():
            raise TaskEnvironmentError(f"A task '{self.name}' exists already. Choose another name; `rlbench-pin list` shows all.")
        fill = {"name": self.name, "cls": camel_case(self.name), "title": self.name.replace("_", " ").capitalize()}
        pairs = [(self.out / f"{self.name}{end}", text.substitute(fill)) for end, text in ((".py", TASK), (".toml", SCENE))]
        with storing(self.out):
            taken = [str(path) for path, _ in pairs if path.exists()]
        if taken:
            raise TaskEnvironmentError(f"{' and '.join(taken)} would be overwritten. Choose another name or folder.")
        _write_pair(pairs)
        file = pairs[0][0]
        print(*(path for path, _ in pairs), sep="\n")
        print(f"Next: rlbench-pin view {file}", f"then rlbench-pin check --task-file {file} --episodes 20", sep="\n")
        return 0


def _write_pair(pairs: list[tuple[Path, str]]) -> None:
    """Write both files or none."""
    written = []
    try:
        for path, text in pairs:
            written.append(write_whole(path, text.encode()))
    except (StorageError, KeyboardInterrupt):
        for path in written:
            path.unlink(missing_ok=True)
        raise
