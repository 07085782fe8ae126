"""Episodes of an evaluation in a page, as they are played."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from rlbench_pin.cli.process.pages import PageOptions, check_port, live_module, live_page
from rlbench_pin.evaluation.run import EpisodeRunner, EvaluationConfig

MakeRunner = Callable[[EvaluationConfig], EpisodeRunner]
"""Makes what plays episodes."""


@contextmanager
def watched(wanted: PageOptions, title: str) -> Iterator[MakeRunner]:
    """Yield what makes the runners of an evaluation; where a page is wanted, it is there for the duration of the block.

    Args:
        wanted: What the user asked for.
        title: What the page is called.
    """
    check_port(wanted)
    if not wanted.live:
        yield EpisodeRunner
        return
    live = live_module()
    with live_page(live.EvaluationView, title, wanted) as view:
        yield partial(live.LiveRunner, view=view)
