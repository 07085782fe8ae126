"""Episodes of an evaluation in a page, as they are played."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from rlbench_pin.cli.arguments.evaluation.evaluate import Watching
from rlbench_pin.cli.process.pages import announce, check_port, live_module
from rlbench_pin.evaluation.run import EpisodeRunner, EvaluationConfig

MakeRunner = Callable[[EvaluationConfig], EpisodeRunner]
"""Makes what plays episodes."""


@contextmanager
def watched(watching: Watching, title: str) -> Iterator[MakeRunner]:
    """Yield what makes the runners of an evaluation; where a page is wanted, it is there for the duration of the block.

    Args:
        watching: What the user asked for.
        title: What the page is called.
    """
    check_port(watching)
    if not watching.live:
        yield EpisodeRunner
        return
    module = live_module()
    with module.LiveView.of_evaluation(title, watching.port) as page:
        announce(page.address, watching.browser)
        yield partial(module.LiveRunner, view=page.view)
