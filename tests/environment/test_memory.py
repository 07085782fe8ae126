"""Closed environments give their memory back."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import re
from rlbench_pin.environment.presets import low_dim_config, make_environment

def resident():
    return int(re.search(r"VmRSS:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1024

def build():
    environment = make_environment(low_dim_config())
    environment.get_task("reach_target").reset(seed=0)
    return environment

build().shutdown()
before = resident()
environments = [build() for _ in range(8)]
opened = resident()
for environment in environments:
    environment.shutdown()
print(before, opened, resident())
"""


@pytest.mark.simulation
def test_closed_environments_give_their_memory_back() -> None:
    """Each takes some 30 MB while it is open; after closing, a small part of that is left, however many there were."""
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=300, check=True)
    before, opened, closed = map(float, done.stdout.split())
    assert opened - before > 100.0
    assert closed - before < 0.25 * (opened - before)
