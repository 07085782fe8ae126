"""The four how-to guides of CONTRIBUTING.md: their snippets, put into a copy of the package, do what the page says."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
SECTION = PAGE[PAGE.index("## Four how-to guides") : PAGE.index("## Tests that need other libraries")]

DEMO = """
import numpy as np
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.actions.modes import MoveArmThenGripper
from rlbench_pin.environment.actions.modes import Discrete
from rlbench_pin.environment.actions.modes import JointPosition

def play(task, **settings):
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0, **settings) as env:
        loop = env.get_task(task)
        return loop, loop.get_demos(1, live_demos=True)[0]
"""

pytestmark = pytest.mark.simulation


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of package and scripts, and of what the tests of control share."""
    for folder in ("rlbench_pin", "scripts"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "tests/control").mkdir(parents=True)
    shutil.copy(ROOT / "tests/control/conftest.py", tmp_path / "tests/control")
    return tmp_path


def snippet(file: str) -> str:
    """Return the snippet whose first line names a file, without that line."""
    (text,) = re.findall(rf"```python\n# {re.escape(file)}[^\n]*\n(.*?)```", SECTION, re.DOTALL)
    return text


def put(copy: Path, file: str, before: str, text: str, instead: bool = False) -> None:
    """Insert `text` before the only line of a file that begins with `before`, or instead of it."""
    lines = (copy / file).read_text(encoding="utf-8").splitlines(keepends=True)
    (where,) = (i for i, line in enumerate(lines) if line.startswith(before))
    lines[where : where + instead] = [text]
    (copy / file).write_text("".join(lines), encoding="utf-8")


def run(copy: Path, *arguments: str) -> str:
    """Run Python on the copy and return what it printed."""
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    result = subprocess.run([sys.executable, *arguments], cwd=copy, env=environment, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_an_arm_is_its_description(copy: Path) -> None:
    """A demonstration is played by the arm of the page, and by name, gymnasium's ids play the arm that is the default."""
    file = "rlbench_pin/robot/description.py"
    put(copy, file, "from rlbench_pin.assets", "from dataclasses import replace\n")
    put(copy, file, "SUPPORTED_ROBOTS: Mapping", snippet(file), instead=True)
    code = (
        'loop, demo = play("reach_target", robot_setup="Panda_High"); print(demo[0].joint_positions.round(2)[3], len(demo) > 9)'
    )
    assert run(copy, "-c", DEMO + code).split() == ["-1.2", "True"]
    put(copy, file, "DEFAULT_ROBOT = ", 'DEFAULT_ROBOT = "panda_high"\n', instead=True)
    code = 'import gymnasium, rlbench_pin; env = gymnasium.make("rlbench_pin/reach_target-state-v0")\n'
    assert run(copy, "-c", code + 'print(env.reset(seed=0)[0]["joint_positions"].round(2)[3])').split() == ["-1.2"]


def test_a_controller_is_a_module_a_line_and_a_test(copy: Path) -> None:
    """The test of the page passes with the controller of the page."""
    for file in ("rlbench_pin/control/joint_pd.py", "tests/control/test_joint_pd.py"):
        (copy / file).write_text(snippet(file), encoding="utf-8")
    door = "rlbench_pin/control/__init__.py"
    put(copy, door, "from rlbench_pin.control.operational_space", "from rlbench_pin.control.joint_pd import JointPD\n")
    put(copy, door, '    "JointImpedance"', '    "JointPD",\n')
    assert "1 passed" in run(copy, "-m", "pytest", "-p", "no:cacheprovider", "--rootdir", str(copy), "tests/control")


def test_a_low_dimensional_observation_is_two_files(copy: Path) -> None:
    """Four lines bring it to observations, to gymnasium's space and state, into files and back."""
    put(copy, "rlbench_pin/observation.py", '    "task_low_dim_state",', '    "finger_gap",\n')
    put(copy, "rlbench_pin/observation.py", "    misc: dict", "    finger_gap: float | None = None\n")
    file = "rlbench_pin/environment/observations/config.py"
    put(copy, file, '    "task_low_dim_state"', snippet(file))
    put(copy, file, "    model: ModelObservationConfig", "    finger_gap: bool = False\n")
    code = """
loop, demo = play("reach_target")
print(round(demo[0].finger_gap, 3), len(demo[0].get_low_dim_data()))
import gymnasium, rlbench_pin
env = gymnasium.make("rlbench_pin/reach_target-state-v0")
print(env.reset(seed=0)[0]["finger_gap"].round(3)[0], env.observation_space["finger_gap"].high[0].round(3))
from rlbench_pin.cli.main import main
assert main(["record", "reach_target", "--episodes", "1", "--workers", "0", "--out", "data", "--products"]) == 0
with Environment(MoveArmThenGripper(JointPosition(), Discrete()), "data", low_dim_config()) as env:
    print(round(env.get_demos("reach_target", 1)[0][0].finger_gap, 3))
"""
    printed = run(copy, "-c", DEMO + code).split()
    assert printed[:4] == ["0.08", "41", "0.08", "0.08"]
    assert printed[-1] == "0.08"


def test_the_height_of_the_table_is_one_line(copy: Path) -> None:
    """At another height the arm plays the same task, things rest on the table, and a camera sees its top there."""
    file = "rlbench_pin/spatial.py"
    put(copy, file, "TABLE_HEIGHT = ", snippet(file), instead=True)
    run(copy, "scripts/build_assets.py", "--family", "room")
    code = """
loop, demo = play("slide_block_to_target")
print(demo[0].gripper_pose[2].round(3), demo[-1].task_low_dim_state[2].round(2))
config = low_dim_config(); config.overhead_camera.set_all(True)
with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0) as env:
    cloud = env.get_task("reach_target").reset(seed=0)[1].overhead_point_cloud
print(np.median(cloud[..., 2]).round(3))
"""
    assert run(copy, "-c", DEMO + code).split() == ["1.401", "0.73", "0.7"]
