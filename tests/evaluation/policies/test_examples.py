"""The examples of `examples/policies` do what their page says."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rlbench_pin.environment import Environment
from rlbench_pin.evaluation.policies import PolicyClient, PolicyContext, PolicyFault, open_policy, policy_server

EXAMPLES = Path(__file__).resolve().parents[3] / "examples" / "policies"
ALONE = """
import runpy, sys
sys.modules["rlbench_pin"] = None
sys.path.insert(0, ".")
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], {}, "__main__")
"""


def reaches(policy: PolicyClient) -> bool:
    """Whether a policy touches the ball within 100 actions."""
    settings = policy.settings
    with Environment(settings.make_action_mode(), obs_config=settings.make_obs_config()) as environment:
        task = environment.get_task("reach_target")
        instructions, observation = task.reset(seed=3)
        low, high = task.action_bounds()
        policy.reset(instructions[0], PolicyContext("panda", 7, tuple(low), tuple(high), 0.05, 100, seed=1))
        for _ in range(100):
            observation, reward, over = task.step(policy.act(observation))
            if over:
                return reward == 1.0
    return False


def wait_for(policy: PolicyClient) -> None:
    """Wait until a policy is served."""
    for _ in range(600):
        try:
            _ = policy.settings
            return
        except PolicyFault:
            time.sleep(0.05)


@pytest.mark.simulation
def test_with_and_without_rlbench_pin(tmp_path: Path) -> None:
    """Both reach the ball: one in a process of its own, the other in one in which rlbench_pin cannot be imported."""
    for file in (EXAMPLES / "without_rlbench_pin.py", Path(policy_server.__file__)):
        shutil.copy(file, tmp_path)
    mine = open_policy(f"{EXAMPLES}/my_policy.py:GoThere")
    assert reaches(mine)
    mine.close()
    address = f"unix:{tmp_path}/policy.sock"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, "-c", ALONE, "without_rlbench_pin.py", address]
    with subprocess.Popen(command, cwd=tmp_path, env=environment) as server:
        try:
            served = open_policy(address)
            wait_for(served)
            assert served.settings.action_mode == mine.settings.action_mode
            assert reaches(served)
        finally:
            server.kill()
