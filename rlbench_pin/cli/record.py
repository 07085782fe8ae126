"""`rlbench-pin record TASK...`: record demonstrations with several worker processes; a run can be resumed."""

from __future__ import annotations

import json
import re
import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from rlbench_pin.cli.interrupts import INTERRUPTED
from rlbench_pin.cli.list_tasks import named_tasks, split_names
from rlbench_pin.cli.options import (
    AnyTasks,
    Cameras,
    Compression,
    Disturbances,
    EngineName,
    MaybeBool,
    MaybeInt,
    MaybePath,
    MaybeProtocol,
    OnlyTasks,
    Products,
    RenderMode,
    RobotName,
    Size,
    check_at_least,
    make_engine,
    with_defaults,
)
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.observation import CAMERAS

if TYPE_CHECKING:
    from rlbench_pin.evaluation.protocols import Protocol
    from rlbench_pin.recording.config import RecordConfig
    from rlbench_pin.recording.record import RecordReport

DEFAULT_OUT = Path("out/dataset")
_PAIR = re.compile(r"\d+,\d+")
_BOOLEANS = ("true", "false")


@dataclass(frozen=True)
class KnownNames:
    """Flags of RLBench's generators, accepted as aliases. Underscores and hyphens are equivalent; lists may have commas."""

    tasks: OnlyTasks = ()
    """Same as the task names."""
    save_path: MaybePath = None
    """Same as `--out`."""
    processes: MaybeInt = None
    """Same as `--workers`."""
    episodes_per_task: MaybeInt = None
    """Same as `--episodes` with `--per-variation`; with `--all-variations True`, same as `--episodes` alone."""
    all_variations: MaybeBool = None
    """True spreads the episodes of a task over its variations, as `record` does; False counts them for each variation."""

    @property
    def are_used(self) -> bool:
        """Whether any of them was given."""
        return any(getattr(self, f.name) not in (None, ()) for f in fields(self))


@dataclass(frozen=True)
class Record:
    """Plan demonstrations of tasks and write them to a dataset. Use `--resume` to continue after an interruption."""

    tasks: tyro.conf.Positional[AnyTasks] = ()
    """Task names, as `rlbench-pin list` prints them, separated by spaces or commas, `all`, or task files. With `--resume` and no
    name: the tasks recorded before."""
    protocol: MaybeProtocol = None
    """Protocol, such as peract18 or gembench, or a TOML file: fixes tasks, episodes, seeds, cameras, image size and arm.
    `rlbench-pin list --protocols` lists them."""
    split: Literal["train", "validation", "test"] = "train"
    """Split of the protocol to record. `test` has the start states of the evaluation: do not train on it."""
    episodes: int = 10
    """Episodes of each task, spread evenly over its variations."""
    per_variation: bool = False
    """Record `--episodes` of each variation instead of each task."""
    variations: int = -1
    """Maximum number of variations of a task; -1 is all."""
    seed: int = 0
    """Seed of the recording. The same seed gives the same files for any number of workers."""
    workers: int = 1
    """Number of worker processes; 0 runs all in this process."""
    engine: EngineName = "processes"
    """Engine: processes of this machine, or a Ray cluster."""
    resume: bool = False
    """Continue the recording in the folder. Settings that are not given are those of the recording."""
    trust_task_files: bool = False
    """Run the task files in the folder, for tasks that are neither installed nor named as files. Read them first."""
    image_size: Size = (128, 128)
    """Width and height of the images [px]."""
    cameras: Cameras = CAMERAS
    """Cameras whose images are stored."""
    products: Products = ("rgb", "depth", "mask")
    """Images of each camera: rgb, depth, mask, point_cloud; `--products` without a value records no images."""
    compression: Compression = "gzip"
    """Compression: `gzip` gives smaller files, `lzf` is faster."""
    max_attempts: int = 10
    """Maximum number of attempts for each episode."""
    renderer: RenderMode = "opengl3"
    """`opengl3` draws shadows; `opengl` draws none and is faster."""
    arm_max_velocity: float = 1.0
    """Limit of the speed along the joint-space path [rad/s]."""
    arm_max_acceleration: float = 4.0
    """Limit of the acceleration along the joint-space path [rad/s^2]."""
    robot: RobotName = "panda"
    """Name of the arm, or path of its TOML file."""
    paired: Annotated[tuple[str, ...], tyro.conf.arg(metavar="ARM...", help_behavior_hint="")] = ()
    """Arms, separated by spaces or commas. Each gets its own dataset, in a folder of `--out` with its name. An episode is stored
    only if all arms demonstrate it at the same attempt of the same seed."""
    factors: Annotated[str, tyro.conf.arg(metavar="FACTOR:LEVEL+...", help_behavior_hint="(default: none)")] = ""
    """Factors of generalisation of all episodes, such as `light_color:2+table_texture:1`; `rlbench-pin factors` lists them."""
    disturb: Disturbances = ()
    """Disturbances for recovery demonstrations: one happens at a random time in each episode, and the planner continues. `push`
    moves the gripper aside by 3 cm; `slip` opens the fingers soon after a grasp; `stop` stops the arm."""
    out: Path = DEFAULT_OUT
    """Folder of the dataset."""
    json: bool = False
    """Print the report as JSON."""
    known: tyro.conf.OmitArgPrefixes[KnownNames] = field(default_factory=KnownNames)
    """Flags of RLBench's generators."""

    def run(self) -> int:
        """Record; return 1 when episodes are missing at the end."""
        if self.known.are_used:
            return self._in_our_names().run()
        check_at_least(self, workers=0)
        if self.protocol is None and self.split != "train":
            raise TaskEnvironmentError(f"--split {self.split} needs a protocol. Use `rlbench-pin record --protocol NAME`.")
        worst = 0
        arms = _paired_folders(self.paired, self.out) or {self.robot: self.out}
        for robot, out in arms.items():
            code = self._record(robot, out)
            if code == INTERRUPTED:
                return code
            worst = max(worst, code)
        return worst

    def _record(self, robot: str, out: Path) -> int:
        from rlbench_pin.cli.progress import RecordBar, stopping_gently
        from rlbench_pin.recording.record import record

        config, engine = self._config(robot, out), make_engine(self.engine, self.workers)
        with stopping_gently() as stop, closing(RecordBar("record")) as bar:
            report = record(
                config,
                out,
                engine=engine,
                resume=self.resume,
                on_progress=bar,
                stop=stop,
                trust_task_files=self.trust_task_files,
            )
        code = print_report(report, out, self._resume_command(out), as_json=self.json)
        return INTERRUPTED if code and stop.is_set() else code

    def _in_our_names(self) -> Record:
        """Return the same command with our flags in place of those of other generators.

        Raises:
            TaskEnvironmentError: A setting was given under both names.
        """
        known = self.known
        changes: dict[str, Any] = {"known": KnownNames(), "tasks": (*self.tasks, *known.tasks)}
        for ours, theirs in {"out": "save_path", "workers": "processes", "episodes": "episodes_per_task"}.items():
            value = getattr(known, theirs)
            if value is None:
                continue
            if getattr(self, ours) not in (getattr(type(self)(), ours), value):
                raise TaskEnvironmentError(
                    f"--{ours} is {getattr(self, ours)} and --{theirs} is {value}, but both are the same setting. Leave one of "
                    "them out."
                )
            changes[ours] = value
        if known.all_variations is not None or known.episodes_per_task is not None:
            changes["per_variation"] = self.per_variation if known.all_variations else True
        return replace(self, **changes)

    def with_recorded_defaults(self) -> type[Record]:
        """Return this command with the settings that its folder records as defaults.

        Raises:
            DatasetError: The folder records nothing that can be read.
        """
        from rlbench_pin.recording.config import RECORDING, read_recording

        out = self.known.save_path or self.out
        folders = [*_paired_folders(self.paired, out).values()] or [out]
        if not (folders[0] / RECORDING).exists():
            return type(self)
        config = read_recording(folders[0])
        defaults = {
            **{
                name: getattr(config, name)
                for name in ("episodes", "per_variation", "variations", "seed", "max_attempts", "robot", "factors", "disturb")
            },
            **{name: getattr(config.images, name) for name in ("image_size", "cameras", "products", "compression")},
            "renderer": config.images.render_mode,
            "arm_max_velocity": config.max_velocity,
            "arm_max_acceleration": config.max_acceleration,
        }
        return with_defaults(Record, defaults)

    def with_protocol_defaults(self) -> type[Record]:
        """Return this command with the values of its protocol as defaults: all other values are then from the user.

        Raises:
            UnknownName: There is no such protocol, or it has no such split.
            ProtocolError: It cannot be used.
        """
        from rlbench_pin.evaluation.protocols import ProtocolFileError

        try:
            return with_defaults(Record, self._fixed(self._protocol()))
        except ProtocolFileError:  # `_config` raises it
            return type(self)

    def _protocol(self) -> Protocol:
        from rlbench_pin.evaluation.protocols import load_protocol

        return load_protocol(self.protocol or "").for_split(self.split)

    def _fixed(self, protocol: Protocol) -> dict[str, Any]:
        """Return the arguments that a protocol fixes. Only the first attempt has the start state of a test episode."""
        protocol.check_tasks_exist()
        split = protocol.split(self.split)
        return {
            "tasks": protocol.task_names,
            "episodes": split.episodes,
            "per_variation": protocol.episodes_of == "variation",
            "variations": -1,
            "seed": split.seeds[0],
            "image_size": protocol.image_size,
            "cameras": protocol.cameras,
            "robot": protocol.robot,
            "paired": (),
            **({"max_attempts": 1} if self.split == "test" else {}),
        }

    def _protocol_episodes(self) -> dict[str, tuple[tuple[int, int], ...]]:
        """Return task -> variation and seed of each episode of the protocol; empty without one.

        Raises:
            ProtocolConflict: An argument contradicts the protocol.
        """
        from rlbench_pin.evaluation.protocols.plan import split_places
        from rlbench_pin.evaluation.run import evaluation_seed
        from rlbench_pin.recording.config import item_seed

        if self.protocol is None:
            return {}
        protocol = self._protocol()
        fixed = self._fixed(protocol)
        given = {name: getattr(self, name) for name in fixed} | {"tasks": named_tasks(self.tasks)}
        given["cameras"] = fixed["cameras"] if set(self.cameras) == set(fixed["cameras"]) else self.cameras
        protocol.check_agrees(given, fixed, tasks="TASK...")
        found: dict[str, tuple[tuple[int, int], ...]] = {}
        for task, places in split_places(protocol, self.split).items():
            if self.split == "test":
                found[task] = tuple((variation, evaluation_seed(seed, number)) for variation, seed, number in places)
                continue
            counted: Counter[tuple[int, int]] = Counter()
            episodes = []
            for variation, seed, _ in places:
                episodes.append((variation, item_seed(seed, task, variation, counted[variation, seed])))
                counted[variation, seed] += 1
            found[task] = tuple(episodes)
        return found

    def _config(self, robot: str, out: Path) -> RecordConfig:
        from rlbench_pin.recording.config import RECORDING, ImageConfig, RecordConfig, read_recording

        tasks, before = named_tasks(self.tasks), None
        if self.resume and (not tasks or (out / RECORDING).exists()):
            before = read_recording(out)
        return RecordConfig(
            tasks=tasks if tasks or before is None else before.tasks,
            draw_variations=before is None or before.draw_variations,
            episodes=self.episodes,
            per_variation=self.per_variation,
            variations=self.variations,
            seed=self.seed,
            max_attempts=self.max_attempts,
            max_velocity=self.arm_max_velocity,
            max_acceleration=self.arm_max_acceleration,
            robot=robot,
            factors=self.factors,
            disturb=self.disturb,
            paired=split_names(self.paired) if self.paired or before is None else before.paired,
            listed=self._protocol_episodes() if self.protocol is not None or before is None else before.listed,
            images=ImageConfig(
                cameras=self.cameras,
                products=self.products,
                image_size=self.image_size,
                render_mode=self.renderer,
                compression=self.compression,
                renderer="cpu" if before is None else before.images.renderer,
            ),
        )

    def _resume_command(self, out: Path) -> str:
        engine = [] if self.engine == "processes" else ["--engine", self.engine]
        own_files = any(word.endswith(".py") for word in self.tasks)  # the folder has kept what was named here
        trust = ["--trust-task-files"] if own_files or self.trust_task_files else []
        words = ["rlbench-pin", "record", "--resume", "--out", str(out), "--workers", str(self.workers)]
        return shlex.join([*words, *engine, *trust])


def _paired_folders(paired: Sequence[str], out: Path) -> dict[str, Path]:
    """Return the folder of each arm of `paired`."""
    from rlbench_pin.robot import robot_description

    return {robot: out / robot_description(robot).name for robot in split_names(paired)}


def spelled_out(arguments: Sequence[str]) -> list[str]:
    """Return the arguments of `record` in the form of its parser.

    `--image_size=128,128` becomes two numbers, and `--all_variations` without a value is true.
    """
    result: list[str] = []
    words = [part for argument in arguments for part in _split(argument)]
    for index, word in enumerate(words):
        following = words[index + 1].lower() if index + 1 < len(words) else ""
        flag = result[-1].replace("_", "-") if result else ""
        if flag == "--image-size" and _PAIR.fullmatch(word):
            result += word.split(",")
        elif flag == "--all-variations" and word.lower() in _BOOLEANS:
            result.append(word.capitalize())
        else:
            result.append(word)
        if word.replace("_", "-") == "--all-variations" and following not in _BOOLEANS:
            result.append("True")
    return result


def _split(argument: str) -> list[str]:
    """Split `--flag=value` of the flags that are rewritten."""
    flag, equals, value = argument.partition("=")
    return [flag, value] if equals and flag.replace("_", "-") in ("--image-size", "--all-variations") else [argument]


def print_report(report: RecordReport, out: Path, go_on: str, *, as_json: bool) -> int:
    """Print the recorded and failed episodes and the command that continues; return the exit code."""
    print(json.dumps(as_dict(report), indent=1) if as_json else _text(report, out))
    for result in report.failed:
        item, why = result.item, "; ".join(result.failures)
        print(f"{item.name}, variation {item.variation}, episode {item.index} (seed {item.seed}) failed: {why}", file=sys.stderr)
    if report.missing > len(report.failed):
        print(f"{report.missing} episodes are missing. Continue with:  {go_on}", file=sys.stderr)
    return 1 if report.missing else 0


def as_dict(report: RecordReport) -> dict[str, object]:
    """Return the report as plain values for JSON."""
    return {
        "wanted": report.wanted,
        "found": report.found,
        "recorded": report.recorded,
        "missing": report.missing,
        "frames": report.frames,
        "num_bytes": report.num_bytes,
        "seconds": round(report.seconds, 2),
        "failed_tries": report.causes,
        "failed": [{"task": r.item.name, "seed": r.item.seed, "causes": r.failures} for r in report.failed],
        "worker_deaths": [{"task": d.item.name, "seed": d.item.seed, "cause": d.cause} for d in report.deaths],
    }


def _text(report: RecordReport, out: Path) -> str:
    rate = 60.0 * report.recorded / report.seconds if report.seconds else 0.0
    megabytes = report.num_bytes / 1e6
    lines = [
        f"{report.found + report.recorded} of {report.wanted} episodes in {out}: {report.recorded} recorded now "
        f"({rate:.1f} a minute, {report.frames} frames, {megabytes:.1f} MB), {report.found} recorded before"
    ]
    lines += [f"failed attempts: {', '.join(f'{n} x {cause}' for cause, n in report.causes.items())}"] if report.causes else []
    lines += [f"{death.item.name}: a worker died ({death.cause}) and was replaced" for death in report.deaths]
    return "\n".join(lines)
