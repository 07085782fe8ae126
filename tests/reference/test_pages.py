"""The pages of `docs/reference/` are what the code says."""

from __future__ import annotations

import pytest
from write_reference import PAGES, text_of

from rlbench_pin.spatial import TABLE_HEIGHT
from tests.reference.support import page


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_what_the_code_says(name: str) -> None:
    """Written again, it stays as it is: otherwise run `python scripts/write_reference.py`."""
    assert page(name) == text_of(name), "run `python scripts/write_reference.py`"


def test_the_prose_has_the_height_of_the_table() -> None:
    """The one number of the world that pages say in a sentence."""
    for name in ("action_modes", "observations"):
        assert f"the table top at z = {TABLE_HEIGHT:g}." in page(name)
