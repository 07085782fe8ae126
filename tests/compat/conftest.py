"""Tests of the layer import `rlbench` and `pyrep` as their users do; what one module launched is closed for the next."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.compat import install
from rlbench_pin.compat.simulator import Simulator

install()


@pytest.fixture(scope="module", autouse=True)
def one_simulator_per_module() -> Iterator[None]:
    """Close what the tests of a module have left running."""
    yield
    if Simulator.running is not None:
        Simulator.running.close()
