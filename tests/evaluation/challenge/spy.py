"""A learner that looks for the task, the scene and the seed in what the harness hands it, and writes down what it finds."""

from __future__ import annotations

import gc
import inspect
import json
import os
import pickle
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, ObservationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.evaluation import Demonstration, PolicyContext, TrainingTask, evaluation_seed, public_tasks
from rlbench_pin.evaluation.challenge.config import demonstration_seed
from rlbench_pin.evaluation.run.config import policy_seed
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.sim import World

SMALL = 40
"""So many seeds of runs and numbers of episodes are tried."""


class Spy:
    """Asks for all that may be asked for, and looks everywhere.

    Args:
        report: File to write to.
    """

    def __init__(self, report: str) -> None:
        self.action_mode, self.obs_config = MoveArmThenGripper(JointPosition(), Discrete()), everything()
        self.max_steps, self.report = 3, Path(report)
        self.found: dict[str, Any] = {}
        self.context: PolicyContext | None = None
        self.instruction = ""

    def meta_train(self, tasks: Sequence[TrainingTask]) -> None:
        """Practise nothing."""

    def recall(self, learned: Mapping[str, Any]) -> None:
        """Nothing was learned."""

    def adapt(self, demonstrations: Sequence[Demonstration]) -> Spy:
        """Look through the demonstrations."""
        names = ("random_seed", "seed", "state", "task_name", "variation_number", "attempt", "num_reset_attempts", "versions")
        frames = [frame for demonstration in demonstrations for frame in demonstration.observations]
        self.found["demonstrations"] = len(demonstrations)
        self.found["1 seed, state or name of a demonstration"] = [
            name for demonstration in demonstrations for name in names if hasattr(demonstration, name)
        ]
        self.found["2 waypoints in a demonstration"] = [i for i, f in enumerate(frames) if f.ignore_collisions is not None]
        self.found["3 states and masks in a demonstration"] = sorted({name for f in frames for name in told(f)})
        return self

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Look through the context."""
        self.instruction, self.context = instruction, context
        found = self.found.setdefault("4 task in the context", [])
        found += [context.task] if context.task else []
        self.found.setdefault("5 seed in the context", []).extend(seed_follows(context.seed))

    def act(self, observation: Observation) -> np.ndarray:
        """Look through the observation, and through this process."""
        assert self.context is not None
        self.found.setdefault("6 states and masks in an observation", []).extend(told(observation))
        self.found["7 worlds in this process"] = [
            type(thing).__name__
            for thing in gc.get_objects()
            if type(thing) in (World, Runtime, TaskEnvironment, Environment, Demo)
        ]
        self.found["8 seeds and tasks in the frames that call"] = in_frames()
        self.found["9 open files"] = open_files()
        self.found["10 arguments and environment of the process"] = in_process()
        self.found["11 extra fields"] = [
            n for n in vars(observation) if n not in vars(Observation()) and n != "ignore_collisions"
        ]
        self.found["12 names and seeds in pickles"] = in_pickles(self.context, observation)
        self.found["13 modules of tasks"] = [name for name in sys.modules if name.rpartition(".")[2] in public_tasks()]
        self.report.write_text(json.dumps({**self.found, "seed": self.context.seed, "instruction": self.instruction}))
        assert observation.joint_positions is not None
        return np.append(observation.joint_positions, 1.0)


def everything() -> ObservationConfig:
    """All that the challenge gives."""
    config = ObservationConfig()
    config.set_all(True)
    config.task_low_dim_state = False
    for camera in config.cameras().values():
        camera.mask = False
        camera.image_size = (16, 16)
    config.record_ignore_collisions = True
    config.record_gripper_closing = True
    return config


def told(observation: Observation) -> list[str]:
    """Return what of an observation tells the state of the scene."""
    fields = [name for name, value in vars(observation).items() if value is not None and name.endswith("_mask")]
    fields += ["task_low_dim_state"] if observation.task_low_dim_state is not None else []
    words = ("variation", "description", "mask", "seed", "task", "waypoint", "distance", "object", "state")
    return fields + [name for name in observation.misc if any(word in name for word in words)]


def seed_follows(told_seed: int) -> list[str]:
    """Try all names and small numbers: whether what was told is a seed, or a hash of one."""
    few = range(SMALL)
    plain = {evaluation_seed(s, i) for s in range(3) for i in few} | set(few)
    hashed = {(s, n, i): policy_seed("", s, n, i) for s in range(3) for n in public_tasks() for i in few}
    shown = {(s, n, i): demonstration_seed(s, n, i) for s in range(3) for n in public_tasks() for i in few}
    found = ["plain"] if told_seed in plain else []
    return found + [str(key) for table in (hashed, shown) for key, seed in table.items() if seed == told_seed]


def in_frames() -> list[str]:
    """Look at what the functions that call this one hold: numbers that are seeds of episodes, names of tasks."""
    seeds, names = {evaluation_seed(0, i) for i in range(SMALL)}, set(public_tasks())
    found: list[str] = []
    for info in inspect.stack():
        if info.filename == __file__:
            continue
        for name, value in info.frame.f_locals.items():
            values: Iterable[Any] = value.values() if isinstance(value, dict) else [value]
            found += [f"{info.function}.{name}" for v in values if isinstance(v, int | str) and (v in seeds or v in names)]
    return found


def open_files() -> list[str]:
    """Return the files on disk that this process holds open."""
    found = []
    for number in os.listdir("/proc/self/fd"):
        try:
            target = os.readlink(f"/proc/self/fd/{number}")
        except OSError:
            continue
        if target.startswith("/") and not target.startswith(("/dev/", "/proc/", "/memfd:rlbench_pin_output")):
            found.append(target)
    return found


def in_process() -> list[str]:
    """Return words of the arguments and the environment of this process that name a task or a folder of a run."""
    words = [*sys.argv, *(v for k, v in os.environ.items() if not k.startswith("PYTEST"))]
    return [word for word in words if any(name in word for name in public_tasks()) or "demonstrations" in word]


def in_pickles(*things: object) -> list[str]:
    """Return the names of tasks and the seeds of episodes that are anywhere in these things, as bytes."""
    data = b"".join(pickle.dumps(thing) for thing in things)
    seeds = [seed for seed in (evaluation_seed(1, i) for i in range(SMALL)) if seed.to_bytes(7, "little") in data]
    return [*(name for name in public_tasks() if name.encode() in data), *map(str, seeds)]
