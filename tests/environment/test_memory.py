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


MANY_EPISODES = """
import re
import sys
from rlbench_pin.environment.factors import factor_catalogue
from rlbench_pin.environment.presets import image_config, make_environment

def resident():
    return int(re.search(r"VmRSS:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1024

with make_environment(image_config((64, 64), ("front",))) as environment:
    task = environment.get_task("put_rubbish_in_bin")
    chosen = {n: len(f.levels) for n, f in factor_catalogue().items() if not f.why_not(task.task) and f.group != "language"}
    del chosen["placement_right"]
    task.set_factors(chosen)
    for seed in range(int(sys.argv[1])):
        if seed in (100, 300):
            print(resident())
        task.reset(seed=seed)
    print(resident())
"""


@pytest.mark.slow
@pytest.mark.simulation
def test_factors_leave_nothing_behind() -> None:
    """500 episodes with all factors at once: after the first hundred the memory grows by less than 20 MB."""
    words = [sys.executable, "-c", MANY_EPISODES, "500"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=1800, check=True)
    early, middle, late = map(float, done.stdout.split())
    assert late - early < 20.0, (early, middle, late)
