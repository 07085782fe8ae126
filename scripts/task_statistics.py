"""Draw the length of demonstrations and the words of the instructions, after figure 4 of the RLBench paper.

Usage: python scripts/task_statistics.py [TASK ...]
Writes docs/results/demo_lengths.json and .png (mean length of five demonstrations of the first variation, sorted) and
docs/results/words.json and .png (how often each content word occurs in all sentences of all variations).
Tasks in demo_lengths.json are not measured again, unless they are named on the command line.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).parent))

from write_instructions import sentences

from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.tasks import library_names

RESULTS = Path(__file__).resolve().parents[1] / "docs" / "results"
SEEDS = range(5)
WORDS_SHOWN = 70
_FIXED = {"font.family": "DejaVu Sans", "font.size": 7.0}
FUNCTION_WORDS = frozenset(
    re.findall(
        r"\w+",
        """
        a an and are as at away back be been belongs both but by can do does down each for from get go goes has have
        here in into is it its let make no not of off on one onto or other out over please so some stands than that
        the them then there these they this those through to toward towards up upon until use using want wants was
        what when where which while with without you your all any another own too now needs need should must will
        would i me my we us again just only if after before once
        """,
    )
)
"""Words that say nothing about a task: articles, pronouns, prepositions, auxiliary and very general verbs."""


def demo_lengths(name: str) -> list[int]:
    """Return the number of control ticks (0.05 s) of each demonstration of a task."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        task.set_variation(0)
        demos = [task.get_demos(1, live_demos=True, seed=seed)[0] for seed in SEEDS]
        return [len(demo) - 1 for demo in demos]


def count_words(lines: Sequence[str]) -> dict[str, int]:
    """Return how often each content word occurs, the most frequent first."""
    words = (word for line in lines for word in re.findall(r"[a-z]+", line.lower().replace("'s", "")))
    counts = Counter(word for word in words if word not in FUNCTION_WORDS and len(word) > 1)
    return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))


def draw_bars(path: Path, values: Mapping[str, float], label: str, title: str) -> None:
    """Draw one upright bar for each name, in the order of the mapping."""
    with rc_context(_FIXED):
        figure = Figure(figsize=(max(6.0, 0.145 * len(values) + 0.8), 4.2), layout="constrained")
        axes = figure.subplots()
        axes.bar(range(len(values)), list(values.values()), color="#0072B2", width=0.75)
        axes.set_xticks(range(len(values)), list(values), rotation=90)
        axes.set_xlim(-0.8, len(values) - 0.2)
        axes.set_ylabel(label)
        axes.set_title(title)
        axes.spines[["top", "right"]].set_visible(False)
        figure.savefig(path, dpi=130, metadata={"Software": None})


def write(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file."""
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    """Measure what is missing or named, and draw both figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", help="tasks to measure again (default: tasks without a length)")
    named = parser.parse_args().tasks
    file = RESULTS / "demo_lengths.json"
    known: dict[str, list[int]] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    names = library_names()
    for name in tqdm(named or [name for name in names if name not in known], desc="demonstrations", unit="task"):
        known[name] = demo_lengths(name)
        write(file, {name: known[name] for name in names if name in known})
    means = {name: float(np.mean(lengths)) for name, lengths in known.items()}
    title = f"Mean length of {len(SEEDS)} demonstrations, first variation"
    draw_bars(file.with_suffix(".png"), dict(sorted(means.items(), key=lambda item: item[1])), "control ticks of 0.05 s", title)
    lines = [
        line
        for name in tqdm(names, desc="instructions", unit="task")
        for variation in sentences(name)
        for lines in variation.values()
        for line in lines
    ]
    words = count_words(lines)
    write(RESULTS / "words.json", words)
    shown = dict(list(words.items())[:WORDS_SHOWN])
    title = f"The {len(shown)} most frequent of {len(words)} content words in {len(lines)} instructions"
    draw_bars(RESULTS / "words.png", shown, "occurrences", title)


if __name__ == "__main__":
    main()
