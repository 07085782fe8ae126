"""Compare two checkouts of this repository, or two interpreters; the package must compute the same results with both.

    python scripts/compare_behaviour.py OLD NEW                        # everything, hours on two cores
    python scripts/compare_behaviour.py OLD NEW --tasks open_drawer --sections tasks cameras
    python scripts/compare_behaviour.py OLD NEW --renamed renamed.json
    python3.13 scripts/compare_behaviour.py --record new.json          # tasks and cameras, with this interpreter
    python scripts/compare_behaviour.py old.json new.json --out docs/results/interpreters.json

Each section runs once in each checkout, in its own process, with the interpreter of `CHECKOUT/.venv` if it exists:

* tasks: SHA-256 of reset observations, demonstrations and world states, every task, several seeds
* cameras: SHA-256 of demonstrations with five cameras, six tasks
* record: manifests that `rlbench-pin record` writes, with 1 and 2 workers
* evaluate: results files of the expert and of a random policy, with 1 and 2 workers
* names: public names of all packages, with their signatures
* times: processor time of import, step, reset and demonstration, measured in turns

`--renamed` names a JSON file with the intended changes: `{"keys": {"old": "new"}, "names": {"package.Old": "package.New"}}`.
The exit code is 0 if all results are equal. Times are printed and do not change the exit code.

`--record` writes the hashes of one seed of each task to a JSON file; an interrupted run resumes.
Two such files can be compared instead of two checkouts.
`--out` writes the hashes of OLD and, for each compared interpreter, the differences. This file may be OLD for a third one.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

RECORDED = ("tasks", "cameras")
SECTIONS = ("tasks", "cameras", "record", "evaluate", "names", "times")
CAMERA_TASKS = ("reach_target", "open_drawer", "stack_blocks", "take_lid_off_saucepan", "press_switch", "close_jar")
EVALUATED = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "lamp_on", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
TIMED = ("reach_target", "open_drawer", "stack_blocks")
PACKAGES = ("", ".checking", ".control", ".datasets", ".environment", ".errors", ".evaluation", ".gym", ".planning", ".recording",
            ".robot", ".scene", ".sim", ".tasks", ".values", ".spatial", ".urdf", ".observation")  # fmt: skip


# What runs in a checkout -------------------------------------------------------------------------------------------------------


def digest(values: Iterable[tuple[str, object]]) -> str:
    """Return the SHA-256 of named arrays, numbers and texts."""
    result = hashlib.sha256()
    for name, value in values:
        array = np.asarray(value)
        result.update(f"{name} {array.dtype} {array.shape} ".encode())
        result.update(repr(value).encode() if array.dtype == object else array.tobytes())
    return result.hexdigest()


def observation_values(observation: Any) -> Iterator[tuple[str, object]]:
    """Yield the fields of an observation, then what `misc` holds."""
    fields = dict(vars(observation))
    misc = fields.pop("misc", {})
    yield from ((name, fields[name]) for name in sorted(fields) if fields[name] is not None)
    yield from ((f"misc.{name}", misc[name]) for name in sorted(misc))


def demo_digest(demo: Any) -> str:
    """Return the SHA-256 of all frames of a demonstration and of what it says about its start."""
    frames = ((f"{i}.{name}", value) for i, frame in enumerate(demo) for name, value in observation_values(frame))
    start = (("state." + name, value) for name, value in sorted((demo.state or {}).items()) if name != "physics")
    head = (("seed", demo.seed), ("variation", demo.variation_number), ("instructions", "\n".join(demo.instructions)))
    return digest((*frames, *start, *head))


def environments(images: bool) -> Any:
    """Return an environment with low-dimensional data only, or with five cameras at 128 px."""
    from rlbench_pin import environment  # of the checkout

    if not images:
        return environment.make_environment(environment.low_dim_config())
    config = getattr(environment, "image_config", None) or environment.picture_config
    return environment.make_environment(config((128, 128)))


def probe_tasks(tasks: list[str], seeds: int, images: bool = False) -> dict[str, str]:
    """Hash resets, demonstrations and the states after them."""
    hashes = {}
    with environments(images) as environment:
        for name in tasks:
            task = environment.get_task(name)
            for seed in range(seeds):
                try:
                    _, first = task.reset(seed=seed, variation=seed % task.variation_count())
                    hashes[f"{name} {seed} reset"] = digest(observation_values(first))
                    hashes[f"{name} {seed} state"] = digest(sorted(task.world.arrays(exact=False).items()))
                    demo = task.get_demos(1, live_demos=True, seed=seed)[0]
                    hashes[f"{name} {seed} demonstration"] = demo_digest(demo)
                    hashes[f"{name} {seed} end"] = digest(sorted(task.world.arrays(exact=False).items()))
                except Exception as error:  # a failure that both checkouts share is not a difference
                    hashes[f"{name} {seed} error"] = f"{type(error).__name__}"
    return hashes


def probe_names() -> dict[str, str]:
    """Return every public name with its signature, classes with those of their methods."""
    import importlib
    import inspect

    import rlbench_pin

    def signature(value: object) -> str:
        try:
            text = str(inspect.signature(value))  # type: ignore[arg-type]
        except (TypeError, ValueError):
            return type(value).__name__
        text = text.replace(str(Path(rlbench_pin.__file__).parents[1]), "")
        return re.sub(r" at 0x\w+|rlbench_pin\.[a-z_.]*", "", text)  # addresses, and modules of classes and functions

    found = {}
    for suffix in PACKAGES:
        module = importlib.import_module(f"rlbench_pin{suffix}")
        for name in getattr(module, "__all__", ()):
            value = getattr(module, name)
            found[f"rlbench_pin{suffix}.{name}"] = signature(value)
            if inspect.isclass(value) and value.__module__.startswith("rlbench_pin"):
                members = (m for m in dir(value) if not m.startswith("_") and callable(getattr(value, m, None)))
                found |= {f"rlbench_pin{suffix}.{name}.{m}": signature(getattr(value, m)) for m in members}
    return found


def probe_times(repeats: int) -> dict[str, float]:
    """Return processor times [ms]: medians of many steps and resets, and of demonstrations."""
    times: dict[str, list[float]] = {}

    def took(key: str, began: float) -> None:
        times.setdefault(key, []).append(1e3 * (time.process_time() - began))

    with environments(images=False) as environment:
        for name in TIMED:
            task = environment.get_task(name)
            task.reset(seed=0)
            for seed in range(repeats):
                began = time.process_time()
                _, observation = task.reset(seed=seed)
                took("reset", began)
                hold = np.append(observation.joint_positions, 1.0)
                for _ in range(30):
                    began = time.process_time()
                    task.step(hold)
                    took("step", began)
            for seed in range(max(1, repeats // 5)):
                began = time.process_time()
                task.get_demos(1, live_demos=True, seed=seed)
                took(f"demonstration of {name}", began)
    return {key: float(np.median(values)) for key, values in times.items()}


def probe(section: str, options: dict[str, Any]) -> object:
    """Run a section in this process, whose `rlbench_pin` is that of a checkout."""
    if section == "tasks":
        return probe_tasks(options["tasks"], options["seeds"])
    if section == "cameras":
        return probe_tasks([name for name in CAMERA_TASKS if name in options["tasks"]], 1, images=True)
    if section == "names":
        return probe_names()
    return probe_times(options["repeats"])


def record(out: Path, tasks: list[str]) -> None:
    """Write the hashes of tasks and cameras that this interpreter gives to a JSON file; tasks that it has are kept."""
    from rlbench_pin.environment import library_versions  # of the checkout

    run = {"python": platform.python_version(), "machine": platform.machine(), "versions": library_versions(), "differences": []}
    hashes: dict[str, Any] = {section: {} for section in RECORDED}
    if out.exists():
        hashes = json.loads(out.read_text(encoding="utf-8"))
        if hashes.pop("runs") != [run]:
            raise SystemExit(f"{out} was recorded with another interpreter or other versions. Delete it, or pass another file.")
    for name in tasks:
        if f"{name} 0 reset" not in hashes["tasks"]:
            for section in RECORDED:
                hashes[section] |= probe(section, {"tasks": [name], "seeds": 1})
            write_record(out, [run], hashes)


def write_record(out: Path, runs: list[dict[str, Any]], hashes: Mapping[str, object]) -> None:
    """Write a JSON file of hashes and the interpreters that were compared by them."""
    out.write_text(json.dumps({"runs": runs, **hashes}, indent=1) + "\n", encoding="utf-8")


# What compares ------------------------------------------------------------------------------------------------------------------


def run(checkout: Path, *arguments: str, folder: Path) -> str:
    """Run Python with the package of a checkout; return what it prints.

    Raises:
        SystemExit: It fails.
    """
    own = checkout / ".venv" / "bin" / "python"
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    command = [str(own if own.exists() else sys.executable), *arguments]
    result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if result.returncode:
        raise SystemExit(f"{' '.join(arguments[:6])} ... failed in {checkout}:\n{result.stderr[-3000:]}")
    return result.stdout


def probed(checkout: Path, section: str, options: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return what a section gives in a checkout."""
    printed = run(checkout, str(Path(__file__).resolve()), "--probe", section, json.dumps(options), folder=folder)
    answer: dict[str, Any] = json.loads(printed.splitlines()[-1])
    return answer


def recorded(checkout: Path, options: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the manifests of recordings by 1 and 2 workers."""
    tasks = [name for name in CAMERA_TASKS if name in options["tasks"]]
    found = {}
    for workers in ("1", "2"):
        out = folder / f"dataset{workers}"
        flags = ("--episodes", "2", "--image-size", "64", "64", "--workers", workers, "--out", str(out))
        run(checkout, "-m", "rlbench_pin.cli.main", "record", *tasks, *flags, folder=folder)
        found |= {f"{path.relative_to(out)} {workers} workers": path.read_text() for path in sorted(out.rglob("manifest.json"))}
    return found


def evaluated(checkout: Path, options: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the results files of two policies, each by 1 and 2 workers."""
    tasks = [name for name in EVALUATED if name in options["tasks"]]
    config = checkout / "rlbench_pin" / "evaluation" / "run" / "config.py"
    key = ("--policy-seed-key", "0" * 32) if "policy_seed_key" in config.read_text() else ()  # older checkouts have none
    found = {}
    for policy in ("expert", "random"):
        for workers in ("1", "2"):
            out = folder / f"{policy}{workers}.json"
            flags = ("--episodes", "2", "--max-seconds", "40", "--workers", workers, "--out", str(out), *key)
            run(checkout, "-m", "rlbench_pin.cli.main", "evaluate", policy, "--tasks", *tasks, *flags, folder=folder)
            results = json.loads(out.read_text())
            found[f"{policy}, {workers} workers"] = {k: v for k, v in results.items() if k not in ("commit", "sha256")}
    return found


def flat(value: object, renamed: Mapping[str, str], path: str = "") -> dict[str, object]:
    """Return nested dicts and lists as one dict, path -> leaf, with keys renamed."""
    if isinstance(value, dict):
        parts: Iterable[tuple[str, object]] = ((renamed.get(str(k), str(k)), v) for k, v in value.items())
    elif isinstance(value, list):
        parts = ((str(i), v) for i, v in enumerate(value))
    else:
        return {path: value}
    return {p: leaf for key, part in parts for p, leaf in flat(part, renamed, f"{path}/{key}").items()}


def differences(old: dict[str, Any], new: dict[str, Any], renamed: Mapping[str, str]) -> list[str]:
    """Return one line for each value that differs, is missing or is new."""
    before, after = flat(old, renamed), flat(new, {})
    gone = [f"only old: {key.lstrip('/')}" for key in before if key not in after]
    extra = [f"only new: {key.lstrip('/')}" for key in after if key not in before]
    changed = [
        f"{key.lstrip('/')}: {str(before[key])[:90]} -> {str(after[key])[:90]}"
        for key in before
        if key in after and before[key] != after[key]
    ]
    return gone + extra + changed


def compare_times(old: Path, new: Path, options: dict[str, Any], folder: Path) -> None:
    """Print how long each operation takes in both checkouts, measured in turns."""
    rounds: dict[str, list[tuple[float, float]]] = {}
    code = "import time; t = time.process_time(); import rlbench_pin; print(1e3 * (time.process_time() - t))"
    for _ in range(options["rounds"]):
        pair = [probed(checkout, "times", options, folder) for checkout in (old, new)]
        imports = [min(float(run(checkout, "-c", code, folder=folder)) for _ in range(5)) for checkout in (old, new)]
        for key in pair[0]:
            rounds.setdefault(key, []).append((pair[0][key], pair[1][key]))
        rounds.setdefault("import rlbench_pin", []).append((imports[0], imports[1]))
    for key, values in rounds.items():
        ratios = [b / a for a, b in values]
        before, after = np.median(values, axis=0)
        low, middle, high = np.percentile(ratios, (0, 50, 100))
        print(f"  {key:<36} {before:9.3f} ms -> {after:9.3f} ms   ratio {middle:.3f} ({low:.3f} to {high:.3f})")


def compare(section: str, old: Path, new: Path, options: dict[str, Any], renamed: dict[str, dict[str, str]]) -> int:
    """Compare one section, print the result and return the number of differences."""
    with tempfile.TemporaryDirectory() as temporary:
        folders = [Path(temporary) / name for name in ("old", "new")]
        for folder in folders:
            folder.mkdir()
        print(f"{section} ...", flush=True)
        if section == "times":
            compare_times(old, new, options, folders[0])
            return 0
        how = {"record": recorded, "evaluate": evaluated}.get(section)
        with ThreadPoolExecutor(2) as pool:
            both = list(
                pool.map(
                    lambda c, f: how(c, options, f) if how else probed(c, section, options, f),
                    (old, new),
                    folders,
                )
            )
    found = differences(both[0], both[1], renamed.get("names" if section == "names" else "keys", {}))
    print(f"  {len(flat(both[1], {}))} values, {len(found)} differ", *found[: options["shown"]], sep="\n    ", flush=True)
    return len(found)


def compare_records(old: Path, new: Path, shown: int, out: Path | None) -> int:
    """Compare two files of `--record`, print the result and return the number of differences."""
    before, after = (json.loads(path.read_text(encoding="utf-8")) for path in (old, new))
    runs, (run,) = before.pop("runs"), after.pop("runs")
    found = run["differences"] = differences(before, after, {})
    print(
        f"Python {runs[0]['python']} and {run['python']}: {len(flat(after, {}))} values, {len(found)} differ",
        *found[:shown],
        sep="\n  ",
    )
    if out is not None:
        write_record(out, [*runs, run], before)
    return len(found)


def main() -> int:
    """Parse the arguments and compare the sections one after the other."""
    if sys.argv[1:2] == ["--probe"]:
        print(json.dumps(probe(sys.argv[2], json.loads(sys.argv[3]))))
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path, nargs="?", help="checkout before the change, or a file of `--record`")
    parser.add_argument("new", type=Path, nargs="?", help="checkout after the change, or a file of `--record`")
    parser.add_argument("--record", type=Path, metavar="FILE", help="write the hashes of this interpreter, without a comparison")
    parser.add_argument("--out", type=Path, help="JSON file for the comparison of two files")
    parser.add_argument("--sections", nargs="+", choices=SECTIONS, default=SECTIONS)
    parser.add_argument("--tasks", nargs="+", help="names of tasks (default: all of the old checkout)")
    parser.add_argument("--seeds", type=int, default=3, help="seeds of each task")
    parser.add_argument("--rounds", type=int, default=5, help="pairs of time measurements")
    parser.add_argument("--repeats", type=int, default=10, help="resets of each timed task in one measurement")
    parser.add_argument("--renamed", type=Path, help="JSON file with intended changes of keys and names")
    parser.add_argument("--shown", type=int, default=40, help="maximum number of printed differences")
    args = parser.parse_args()
    if args.record:
        from rlbench_pin.tasks import library_names

        record(args.record, args.tasks or list(library_names()))
        return 0
    if args.old is None or args.new is None:
        parser.error("pass two checkouts, or two files of `--record`")
    old, new = args.old.resolve(), args.new.resolve()
    if old.is_file() and new.is_file():
        return int(compare_records(old, new, args.shown, args.out) > 0)
    library = (old / "rlbench_pin" / "tasks" / "library").glob("*.toml")
    options = {"tasks": args.tasks or sorted(path.stem for path in library)}
    options |= {name: getattr(args, name) for name in ("seeds", "rounds", "repeats", "shown")}
    renamed = json.loads(args.renamed.read_text()) if args.renamed else {}
    return int(sum(compare(section, old, new, options, renamed) for section in args.sections) > 0)


if __name__ == "__main__":
    sys.exit(main())
