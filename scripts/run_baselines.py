"""Play all baselines and write docs/results/baselines/, the tables of docs/baselines.md, and the learning curves.

`make baselines` calls it. It takes hours on two cores. Run the same command to resume after an interruption: recordings,
trainings and evaluations continue, and finished results are read. With names of rows, only these are played. It needs the
extras `learn`, `rl` and `classical`.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from baselines_lib.rows import TRIED, Command, Row, by_trial, commands, rows
from baselines_lib.tables import RESULTS, pages
from tqdm import tqdm
from update_readme import write_pages

from rlbench_pin.evaluation import read_results, write_results

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
OUT = Path("out/baselines")
"""Default folders of data, models and results."""


class Run:
    """Commands of `rlbench-pin`, with their output in files.

    Args:
        out: Folder of data, models and results.
        jobs: Worker processes of one command, and trainings at once.
    """

    def __init__(self, out: Path, jobs: int) -> None:
        """Make the folder."""
        self._out, self._jobs = out, jobs
        self._done: set[Command] = set()
        (out / "logs").mkdir(parents=True, exist_ok=True)

    def play(self, row: Row, bar: tqdm) -> None:
        """Run the commands of a row.

        Raises:
            SystemExit: A command failed; says which, and where its output is.
        """
        with ThreadPoolExecutor(self._jobs) as pool:
            for stage in (*row.before, (row.play,)):
                list(pool.map(lambda command: self._call(command, bar), stage))

    def keep(self, row: Row) -> None:
        """Copy the results of a row into the repository; after all are played: until then the checkout stays as it is.

        Policies are called as if the folder of the run were the usual one.
        """
        RESULTS.mkdir(parents=True, exist_ok=True)
        for name, file in row.results.items():
            results = read_results(self._out / file)
            policy = results.policy.replace(str(self._out), str(OUT))
            write_results(RESULTS / f"{name}.json", replace(results, policy=policy))
            if name in by_trial():
                from rlbench_pin.baselines.reinforcement import draw_curves, read_curve  # needs the extra `rl`

                curves = {task: read_curve(self._out / "models" / name / task) for task in TRIED}
                draw_curves(IMAGES / f"curves_{name}.png", curves)

    def _call(self, command: Command, bar: tqdm) -> None:
        """Run a command, once however many rows need it."""
        if command not in self._done:
            words = [word.format(out=self._out, jobs=self._jobs) for word in command]
            log = self._out / "logs" / f"{'_'.join(words)[:120].replace('/', '-')}.log"
            bar.set_postfix_str(" ".join(words[:3]))
            with log.open("a", encoding="utf-8") as file:
                program = [sys.executable, "-m", "rlbench_pin.cli.main", *words, *self._resume(words)]
                code = subprocess.run(program, stdout=file, stderr=subprocess.STDOUT, check=False).returncode
            if code != 0:
                raise SystemExit(
                    f"`rlbench-pin {' '.join(words)}` ended with {code}; '{log}' has its output. Run the same command to resume."
                )
            self._done.add(command)
        bar.update()

    def _resume(self, words: list[str]) -> list[str]:
        """Return the flag that goes on; a recording takes it only where there is one."""
        begun = words[0] != "record" or Path(words[-1], "recording.json").exists()
        return ["--resume"] * begun


def main() -> int:
    """Play the rows that are named, or all."""
    known = rows()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"rows to play: {', '.join(known)}; all when none is named")
    parser.add_argument("--out", type=Path, default=OUT, help="data, models, logs and results (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="worker processes (default: %(default)s)")
    arguments = parser.parse_args()
    if unknown := [name for name in arguments.rows if name not in known]:
        parser.error(f"there is no row {', '.join(unknown)}; choose from {', '.join(known)}")
    chosen = [known[name] for name in arguments.rows or known]
    run = Run(arguments.out, arguments.jobs)
    with tqdm(total=sum(1 for row in chosen for _ in commands(row)), unit="command", dynamic_ncols=True) as bar:
        for row in chosen:
            run.play(row, bar)
    for row in chosen:
        run.keep(row)
    return write_pages(False, pages())


if __name__ == "__main__":
    sys.exit(main())
