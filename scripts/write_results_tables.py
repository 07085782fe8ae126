"""Write the tables of docs/results_files.md: widths of confidence intervals, and numbers of episodes to detect a difference.

The text around them is handwritten. With `--check` nothing is written; it only reports whether the page is out of date.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table
from update_readme import checks_only, replace_part, write_pages

from rlbench_pin.evaluation import episodes_needed
from rlbench_pin.rates import wilson

PAGE = Path(__file__).resolve().parents[1] / "docs" / "results_files.md"
EPISODES = (25, 50, 100, 200, 400, 1000)
RATES = (0.0, 0.48, 0.8, 0.96)
DIFFERENCES = ((0.5, 0.55), (0.8, 0.85), (0.5, 0.6), (0.8, 0.9), (0.5, 0.7))
SHARED = (0.0, 0.5, 0.8)


def widths() -> str:
    """Return the intervals of some rates."""
    rows = []
    for n in EPISODES:
        spans = [wilson(round(rate * n), n) for rate in RATES]
        rows.append((str(n), *(f"{100 * low:.1f} to {100 * high:.1f}" for low, high in spans)))
    return table(("Episodes", *(f"{rate:.0%}" for rate in RATES)), rows, "r" * (1 + len(RATES)))


def needed() -> str:
    """Return how many episodes some differences need."""
    rows = [(f"{p:.0%} and {q:.0%}", *(str(episodes_needed(p, q, shared)) for shared in SHARED)) for p, q in DIFFERENCES]
    return table(("Rates", *(f"{shared:.0%} as hard for both" for shared in SHARED)), rows, "lrrr")


def page() -> str:
    """Return the page with its tables as they should be."""
    text = replace_part(PAGE.read_text(encoding="utf-8"), "widths", f"\n{widths()}\n")
    return replace_part(text, "needed", f"\n{needed()}\n")


if __name__ == "__main__":
    sys.exit(write_pages(checks_only(__doc__), {PAGE: page()}))
