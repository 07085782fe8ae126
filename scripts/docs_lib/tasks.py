"""The gallery of tasks: an index with filters, and one page for each task of the library."""

from __future__ import annotations

import inspect
import json
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from reference_lib.docs import arguments_of, doc_of, table

from docs_lib.public import ROOT
from rlbench_pin.checking.page import interval
from rlbench_pin.errors import BoundaryError
from rlbench_pin.evaluation.sets import set_contents, task_families, task_tier
from rlbench_pin.robot import DEFAULT_ROBOT
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene import SceneSpec
from rlbench_pin.sim import Sensor, World
from rlbench_pin.tasks import Condition, Task, camel_case, library_names, task_class, task_scene

FOLDER = "task_gallery"
DOCS = ROOT / "docs"
DRAWS = 20
"""Draws of an episode until its objects find a place."""
RATES = {
    "first_try": "Success at the first try, seeds used in development",
    "unseen": "Success at the first try, unseen seeds",
    "within_tries": "Success within ten tries",
    "stable_success": "Success still holds after 1 s",
    "replay": "Replay of the actions succeeds",
    "key_frames": "Replay of the key frames succeeds",
    "friction_only": "Success with friction only",
    "noop": "No-op policy",
    "random": "Random policy",
}
"""Key of a rate in docs/results/demo_success.json -> its title."""
HEAD = """# Task gallery

{count} tasks. The left half of each image is the start, the right half the result 1 s after success. Type a word of the name
or of the sentence, or choose a set, a number of variations or a tier. `rlbench-pin list` prints the same list.

:::{{table}}
:class: task-list

{table}
:::
"""


def task_pages(source: Path) -> dict[str, str]:
    """Return file -> text of the index and of one page for each task."""
    names = library_names()
    with ProcessPoolExecutor() as pool:
        conditions = dict(zip(names, pool.map(condition_rows, names, chunksize=8)))
    pages = {f"{FOLDER}/{name}.md": page(name, conditions[name], source) for name in names}
    rows = [index_row(name, source) for name in names]
    head = ("Task", "Sentence", "Variations", "Tier", "Sets")
    return {f"{FOLDER}/index.md": HEAD.format(count=len(names), table=table(head, rows)), **pages}


def index_row(name: str, source: Path) -> tuple[str, ...]:
    """Return the row of a task in the index."""
    image = f"[![{name}]({from_gallery(DOCS / 'images' / 'gallery' / f'{name}.jpg', source)})]({name}.md)"
    sets = " ".join(f"`{each}`" for each in sets_of(name))
    return f"{image}<br>[{name}]({name}.md)", first_sentence(name), str(variation_count(name)), tier(name), sets


def page(name: str, conditions: Sequence[Sequence[str]], source: Path) -> str:
    """Return the page of a task."""
    kind = task_class(name)
    scene = task_scene(kind)
    files = (f"gallery/{name}.jpg", f"sheets/{name}.jpg", f"videos/{name}.webp")
    image, sheet, video = (from_gallery(DOCS / "images" / file, source) for file in files)
    title = (inspect.getdoc(inspect.getmodule(kind)) or "").split("\n")[0]
    parts = [
        f"---\norphan: true\n---\n\n# {name}",
        title,
        f"[![Start and result of {name}]({image})]({sheet})",
        f"Left: the start with seed 0 and variation 0. Right: the result 1 s after success. The [contact sheet]({sheet}) shows "
        "the events of the demonstration in all cameras.",
        f"![A demonstration of {name}]({video})",
        table(("", ""), facts(name, scene)),
        "## Goal",
        f"```{{eval-rst}}\n.. autoclass:: rlbench_pin.tasks.{camel_case(name)}\n   :no-index-entry:\n```",
        "## Sentences",
        sentences()[name],
        "## Success conditions",
        "All of them have to hold at the same time. The table shows variation 0; lengths are in m, angles in rad.",
        table(("Condition", "Applied to", "Meaning"), conditions),
        "## Randomisation",
        randomisation(scene),
        "## Demonstrations",
        statistics(name),
        "## Deviations from the specification",
        deviations(scene),
    ]
    if history := getattr(scene, "history", ()):
        rows = [(str(entry.version), entry.change, entry.release or "") for entry in history]
        parts += ["## History", table(("Version", "Change", "Release"), rows)]
    files = [Path(inspect.getfile(kind)), Path(scene.file)]
    links = [f"* [{file.relative_to(ROOT)}]({from_gallery(file, source)})" for file in files]
    return "\n\n".join([*parts, "## Files", "\n".join(links)]) + "\n"


def from_gallery(file: Path, source: Path) -> str:
    """Return a file of the repository as pages of the gallery link it."""
    return os.path.relpath(file, source / FOLDER)


def facts(name: str, scene: SceneSpec) -> list[tuple[str, str]]:
    """Return the rows of the first table."""
    sets = ", ".join(f"`{each}`" for each in sets_of(name))
    rows = [("Variations", str(variation_count(name))), ("Version", str(getattr(scene, "version", 1)))]
    rows += [("Tier", tier(name))] if tier(name) else []
    return [*rows, ("Sets", sets), ("Load it", f'`environment.get_task("{name}")`'), ("Watch it", f"`rlbench-pin view {name}`")]


def variation_count(name: str) -> int:
    """Return how many variations a task has."""
    kind = task_class(name)
    return kind.variation_count(object.__new__(kind))


def tier(name: str) -> str:
    """Return the tier of a public task, "" for the others."""
    return str(task_tier(name)) if any(name in set_contents()[f"tier{number}"].tasks for number in range(1, 5)) else ""


def sets_of(name: str) -> list[str]:
    """Return the sets that a task is in, its family first."""
    families = task_families()
    found = [each for each, content in set_contents().items() if name in content.tasks and not each.startswith("tier")]
    return sorted(found, key=lambda each: each not in families)


@cache
def sentences() -> dict[str, str]:
    """Return task -> its tables of sentences, as docs/results/instructions.md has them."""
    parts = re.split(r"^## (\w+)\n", (DOCS / "results" / "instructions.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {name: text[text.index("| Kind ") :].strip() for name, text in zip(parts[1::2], parts[2::2])}


def first_sentence(name: str) -> str:
    """Return the first sentence of variation 0."""
    return re.search(r"\| training \| (.*?)(<br>| \|)", sentences()[name])[1]  # type: ignore[index]


# Conditions -------------------------------------------------------------------------------------------------------------------


def condition_rows(name: str) -> list[tuple[str, str, str]]:
    """Return one row for each success condition of variation 0, with members of combined conditions below it."""
    kind = task_class(name)
    with World(task_scene(kind), robot_description(DEFAULT_ROBOT)) as world:
        task = kind(world)
        task.init_task()
        begin(task)
        return [row for condition in task.get_success_conditions() for row in rows_of(condition, "")]


def begin(task: Task, variation: int = 0) -> None:
    """Begin an episode with the first seed for which its objects find a place."""
    for seed in range(DRAWS):
        try:
            task.begin_episode(variation, np.random.default_rng(seed))
            return
        except BoundaryError:
            continue
    raise SystemExit(f"{task.get_name()}, variation {variation}: {DRAWS} successive draws found no placement.")


def rows_of(condition: Condition, before: str) -> Iterable[tuple[str, str, str]]:
    """Yield the row of a condition, then those of its members."""
    cls = type(condition)
    members = getattr(condition, "members", ())
    arguments = [(key, getattr(condition, key)) for key in inspect.signature(cls).parameters if hasattr(condition, key)]
    units = {key: unit_of(text) for key, text in arguments_of(cls).items()}
    arguments_shown = [
        f"{key} {shown(value)}{units.get(key, '')}" for key, value in arguments if key not in ("robot", "gripper", "members")
    ]
    yield f"{before}`{cls.__name__}`", ", ".join(arguments_shown), doc_of(cls).first
    for number, member in enumerate(members, 1):
        yield from rows_of(member, f"{before}{number}. ")


def unit_of(text: str) -> str:
    """Return the unit that the text of an argument names, with a space before it."""
    found = re.search(r"\[(m|rad)\](, \[m\]|\ or \[m\])?", text)
    return "" if found is None else f" {found[1]}" if not found[2] else " (rad or m)"


def shown(value: object) -> str:
    """Return an argument of a condition: names of objects, numbers, the size of sensors."""
    if isinstance(value, Sensor):
        return f"`{value.name}` ({value.shape} {size(value.size)} m)"
    if hasattr(value, "name"):
        return f"`{value.name}`"
    if isinstance(value, float | np.floating):
        return f"{value:.4g}"
    if isinstance(value, np.ndarray):
        return f"{len(value)} points" if value.ndim == 2 else f"({', '.join(f'{v:.3g}' for v in value)})"
    if isinstance(value, list | tuple):
        return ", ".join(shown(item) for item in value) or "none"
    return "" if value is None else str(value).lower()


def size(values: Iterable[float]) -> str:
    """Return lengths of a volume."""
    return " x ".join(f"{v:.4g}" for v in values)


# The other parts ----------------------------------------------------------------------------------------------------------------


def randomisation(scene: SceneSpec) -> str:
    """Return what differs from episode to episode."""
    place = scene.placement
    if place.static:
        lines = ["* The scene stays at its nominal pose in every episode."]
    else:
        low, high = (math.degrees(angle) for angle in place.yaw)
        patch = "the bounding box of all bodies" if place.footprint is None else f"a patch of {size(place.footprint)} m"
        lines = [
            f"* **Pose of the scene**: drawn uniformly over the placement area so that {patch} fits.",
            f"* **Yaw of the scene**: from {low:.0f}° to {high:.0f}°.",
        ]
    lines += [f"* **Region** `{region.name}`, {size(region.size)} m, at `{region.parent}`." for region in scene.region]
    bodies = [f"`{body.name}`" for body in scene.body]
    lines += [f"* **Bodies of the scene**: {', '.join(bodies)}."]
    if scene.excluded_factor:
        rows = [(f"`{factor.name}`", factor.reason) for factor in scene.excluded_factor]
        lines += ["", f"These [factors](../factors.md) cannot change the task:\n\n{table(('Factor', 'Reason'), rows)}"]
    return "\n".join(lines)


@cache
def results() -> dict[str, Any]:
    """Return the content of docs/results/demo_success.json."""
    return json.loads((DOCS / "results" / "demo_success.json").read_text(encoding="utf-8"))


def statistics(name: str) -> str:
    """Return the figures of the demonstrations."""
    found = results()["tasks"].get(name)
    if found is None:
        return "Not measured yet."
    rows = [(title, rate_text(found[key])) for key, title in RATES.items() if found.get(key, {}).get("of")]
    rows += [
        ("Length, median", f"{found['median_simulated_s']:.1f} s, {found['median_frames']:.0f} frames"),
        ("Length, 95th percentile", f"{found['p95_simulated_s']:.1f} s"),
        ("Planning time, median", f"{1000 * found['median_planning_s']:.0f} ms"),
        ("Speed", f"{found['times_real_time']:.1f} x real time"),
    ]
    versions = f"rlbench_pin {results()['versions']['rlbench_pin']}"
    link = f"[All figures](../results/demo_success.md#{name})"
    return f"{table(('Figure', 'Value'), rows)}\n\nShares have their 95 % interval. Measured with {versions}. {link}."


def rate_text(rate: Mapping[str, Any]) -> str:
    """Return a share with its interval and its counts."""
    return f"{interval(rate)}, {rate['count']} of {rate['of']}"


def deviations(scene: SceneSpec) -> str:
    """Return the deviations from the specification."""
    if not scene.deviation:
        return "None."
    kinds = {True: "asked", False: "proposed"}
    rows = [(entry.name, kinds[entry.binding], entry.specified, entry.here, entry.reason) for entry in scene.deviation]
    return f"{table(('What', 'Kind', 'Specified', 'Here', 'Reason'), rows)}\n\n[How to read this table](../deviations.md)."
