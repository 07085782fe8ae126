"""`rlbench-pin record TASK...`: demonstrations by the thousand, resumable, by as many processes as there are cores."""

from __future__ import annotations

import json
import shlex
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from rlbench_pin.cli.arguments import record as arguments
from rlbench_pin.cli.arguments.record import KnownNames
from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.process.engines import make_engine
from rlbench_pin.cli.process.interrupts import INTERRUPTED
from rlbench_pin.cli.process.words import check_at_least
from rlbench_pin.cli.progress import RecordBar, stopping_gently
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.recording.config import PictureConfig, RecordConfig, read_recording
from rlbench_pin.recording.record import RecordReport, record


class Record(arguments.Record):
    """The work of `rlbench-pin record`."""

    def run(self) -> int:
        """Record; 1 when episodes are missing at the end."""
        if self.known.are_used:
            return self._in_our_names().run()
        check_at_least(self, workers=0)
        config = read_recording(self.out) if self.resume and not self.tasks else self._config()
        engine = make_engine(self.engine, self.workers)
        with stopping_gently() as stop, closing(RecordBar("record")) as bar:
            report = record(
                config,
                self.out,
                engine=engine,
                resume=self.resume,
                on_progress=bar,
                stop=stop,
                trust_task_files=self.trust_task_files,
            )
        code = print_report(report, self.out, self._resume_command(), as_json=self.json)
        return INTERRUPTED if code and stop.is_set() else code

    def _in_our_names(self) -> Record:
        """Return the same with our flags in the place of those of other generators.

        Raises:
            TaskEnvironmentError: A setting was given under both names.
        """
        known = self.known
        changes: dict[str, Any] = {"known": KnownNames(), "tasks": (*self.tasks, *known.tasks)}
        for ours, theirs in {"out": "save_path", "workers": "processes", "episodes": "episodes_per_task"}.items():
            value = getattr(known, theirs)
            if value is None:
                continue
            if getattr(self, ours) not in (getattr(Record(), ours), value):
                raise TaskEnvironmentError(f"--{ours} and --{theirs} name the same setting with two values. Give one of them.")
            changes[ours] = value
        if known.all_variations is not None or known.episodes_per_task is not None:
            changes["per_variation"] = self.per_variation if known.all_variations else True
        return replace(self, **changes)

    def _config(self) -> RecordConfig:
        return RecordConfig(
            tasks=named_tasks(self.tasks),
            episodes=self.episodes,
            per_variation=self.per_variation,
            variations=self.variations,
            seed=self.seed,
            max_attempts=self.max_attempts,
            max_velocity=self.arm_max_velocity,
            max_acceleration=self.arm_max_acceleration,
            pictures=PictureConfig(
                cameras=self.cameras,
                products=self.products,
                image_size=self.image_size,
                render_mode=self.renderer,
                compression=self.compression,
            ),
        )

    def _resume_command(self) -> str:
        engine = [] if self.engine == "processes" else ["--engine", self.engine]
        own_files = any(word.endswith(".py") for word in self.tasks)  # the folder has kept what was named here
        trust = ["--trust-task-files"] if own_files or self.trust_task_files else []
        words = ["rlbench-pin", "record", "--resume", "--out", str(self.out), "--workers", str(self.workers)]
        return shlex.join([*words, *engine, *trust])


def print_report(report: RecordReport, out: Path, go_on: str, *, as_json: bool) -> int:
    """Print what was done, what failed and how to go on; return the exit code."""
    print(json.dumps(as_dict(report), indent=1) if as_json else _text(report, out))
    for result in report.failed:
        item, why = result.item, "; ".join(result.failures)
        print(f"{item.name}, variation {item.variation}, episode {item.index} (seed {item.seed}) failed: {why}", file=sys.stderr)
    if report.missing > len(report.failed):
        print(f"{report.missing} episodes are missing. Go on with:  {go_on}", file=sys.stderr)
    return 1 if report.missing else 0


def as_dict(report: RecordReport) -> dict[str, object]:
    """Plain values for JSON."""
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
        f"({rate:.1f} a minute, {report.frames} frames, {megabytes:.1f} MB), {report.found} found there"
    ]
    lines += [f"tries that failed: {', '.join(f'{n} x {cause}' for cause, n in report.causes.items())}"] if report.causes else []
    lines += [f"{death.item.name}: a worker died ({death.cause}) and was replaced" for death in report.deaths]
    return "\n".join(lines)
