"""Success conditions as text."""

from __future__ import annotations

import pytest

from rlbench_pin.builder.playback.conditions import success_texts
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.tasks import find_task


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("task", "texts"),
    [
        ("open_drawer", ("chest/drawer_bottom moved by more than 0.15",)),
        ("stack_blocks", ("at least 2 of block0, block1, block2, block3 inside column",)),
        ("push_button", ("in order (",)),
    ],
)
def test_conditions_say_what_they_ask_for(task: str, texts: tuple[str, ...]) -> None:
    """Each condition of the vocabulary has words, with the names of the scene."""
    with make_environment(low_dim_config()) as environment:
        running = environment.get_task(find_task(task))
        running.reset(seed=0, variation=0)
        said = success_texts(running.task)
    for text, begins in zip(said, texts, strict=False):
        assert text.startswith(begins)
