"""What `rlbench-pin results FILE...` takes."""

from __future__ import annotations

from dataclasses import dataclass

import tyro

from rlbench_pin.cli.process.words import MaybePath, SomeFiles


@dataclass(frozen=True)
class ShowResults:
    """Print tables of results files, compare them episode by episode, draw them.

    Success has its interval of 95 %: Wilson's for a task, a bootstrap with the tasks as strata for the mean over tasks.
    """

    files: tyro.conf.Positional[SomeFiles] = ()
    """Results files, as `rlbench-pin evaluate` writes them."""
    compare: bool = False
    """Compare every further file with the first: McNemar's test on the episodes that both played, by task and in all."""
    held: bool = False
    """Compare success that lasts, instead of success."""
    common: bool = False
    """Compare the episodes that both files have, where they do not have the same."""
    any_limits: bool = False
    """Compare although episodes ended at different limits."""
    plot: MaybePath = None
    """Picture to draw: success by task, the files side by side; PNG or SVG."""
    markdown: bool = False
    """Print the tables in Markdown."""
    json: bool = False
    """Print JSON for programs."""
