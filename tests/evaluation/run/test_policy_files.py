"""A policy whose files change is another policy: an evaluation does not go on with it."""

from __future__ import annotations

import hashlib
import threading
from pathlib import Path

import pytest

from rlbench_pin.evaluation.run import EvaluationConfig, EvaluationConflict, EvaluationProgress, EvaluationStopped, evaluate
from rlbench_pin.evaluation.run.provenance import policy_digests
from rlbench_pin.processes import SerialEngine

POLICY = """
class Still:
    action_mode = {"mode": "MoveArmThenGripper", "arm": "JointPosition", "gripper": "Discrete"}
    obs_config = {"joint_positions": True}
    def reset(self, instruction, context): pass
    def act(self, observation): return [*observation.joint_positions, 1.0]
"""


def sha(content: bytes) -> str:
    """The digest that is expected."""
    return hashlib.sha256(content).hexdigest()


def test_files_that_a_reference_names(tmp_path: Path) -> None:
    """A Python file, a model, a folder with all in it, also as an argument; addresses, modules and names have none."""
    (tmp_path / "models" / "a").mkdir(parents=True)
    file, zipped, inner = tmp_path / "p.py", tmp_path / "m.zip", tmp_path / "models" / "a" / "w b.bin"
    for place, content in ((file, b"1"), (zipped, b"2"), (inner, b"3")):
        place.write_bytes(content)
    assert policy_digests(f"{file}:Still?gain=4") == {str(file): sha(b"1")}
    assert policy_digests(f"sb3:{tmp_path / 'm'}?arm=X") == {str(zipped): sha(b"2")}
    for kind in ("lerobot", "ppo", "sac"):
        assert policy_digests(f"{kind}:{tmp_path / 'models'}") == {str(inner): sha(b"3")}
    own = tmp_path / "own.toml"
    own.write_bytes(b"4")
    assert policy_digests(f"openpi://localhost:1?mapping={own}&token={tmp_path}") == {str(own): sha(b"4")}
    assert policy_digests(f"cloning?folder={tmp_path / 'models'}") == {str(inner): sha(b"3")}
    for other in ("noop", "random", "json:loads", f"unix:{file}", "tcp://localhost:5", "cloning?folder=%00", "cloning?folder="):
        assert policy_digests(other) == {}, other


@pytest.mark.simulation
def test_an_edited_policy_is_refused(tmp_path: Path) -> None:
    """Between the end of one process and `resume`; with the file as it was, it goes on."""
    file, out, stop = tmp_path / "p.py", tmp_path / "x.json", threading.Event()
    file.write_text(POLICY)
    config = EvaluationConfig(policy=f"{file}:Still", tasks=("reach_target",), episodes=2, max_seconds=0.2)

    def after_one(progress: EvaluationProgress) -> None:
        if progress.done:
            stop.set()

    with pytest.raises(EvaluationStopped):
        evaluate(config, out, engine=SerialEngine(), on_progress=after_one, stop=stop)
    file.write_text(f"{POLICY}# edited\n")
    with pytest.raises(EvaluationConflict, match=r"policy_files.*p\.py"):
        evaluate(config, out, engine=SerialEngine(), resume=True)
    file.write_text(POLICY)
    assert len(evaluate(config, out, engine=SerialEngine(), resume=True).episodes) == 2
