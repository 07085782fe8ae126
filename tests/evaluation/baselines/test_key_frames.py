"""Key-frame cloning: clouds, targets, votes, files, and a policy that goes where most votes agree."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("tensorboard")

from rlbench_pin.datasets import key_frames  # noqa: E402
from rlbench_pin.environment import key_frame_actions  # noqa: E402
from rlbench_pin.errors import DatasetError  # noqa: E402
from rlbench_pin.evaluation.baselines.cloning.storage import MODEL, SETTINGS, write_settings, write_tensors  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames import KeyFrameLearner, load_key_frames, policy  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames.clouds import HIGH, LOW, POINTS, make_cloud  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames.examples import KeyFrameExamples, look_at, make_key_frame_examples  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames.learner import CONTEXT, KIND  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames.network import VoteNetwork, Votes  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames.policy import agreed  # noqa: E402
from rlbench_pin.evaluation.baselines.key_frames.poses import axes_of, pose_from, vertical_turn  # noqa: E402
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext  # noqa: E402
from rlbench_pin.observation import Observation  # noqa: E402
from rlbench_pin.spatial import TABLE_HEIGHT, pose_at  # noqa: E402
from tests.evaluation.baselines.demos_that_reach import SENTENCES, gliding_demo, look  # noqa: E402

BALL = np.array([0.25, 0.1, TABLE_HEIGHT + 0.2])


def _examples(count: int = 2) -> KeyFrameExamples:
    demos = [gliding_demo(seed) for seed in range(count)]
    return make_key_frame_examples([(d, [look_at(look(BALL, i)) for i in range(len(key_frames(d)))]) for d in demos])


def test_a_cloud_shows_things_rather_than_table() -> None:
    """Always as many points, all in the box, the table a tenth, each its own nearest neighbour, twice the same."""
    cloud = make_cloud(look(BALL))
    assert cloud.points.shape == (POINTS, 3) and ((cloud.points > LOW) & (cloud.points < HIGH)).all()
    red = cloud.colors[:, 1] == 0.0
    assert red.mean() > 0.3
    np.testing.assert_allclose(np.linalg.norm(cloud.points[red] - BALL, axis=1), 0.05, atol=1e-4)
    gaps = np.linalg.norm(cloud.points[cloud.neighbours] - cloud.points[:, None], axis=-1)
    np.testing.assert_allclose(gaps[:, 0], 0.0, atol=1e-3)
    assert (np.diff(gaps, axis=1) > -1e-3).all()
    np.testing.assert_array_equal(make_cloud(look(BALL)).points, cloud.points)


def test_without_pictures_there_is_no_cloud() -> None:
    """A camera is missing, or nothing lies in the box."""
    with pytest.raises(DatasetError, match="lacks colours or point clouds"):
        make_cloud(Observation())
    away = look(BALL)
    for name in [n for n in vars(away) if n.endswith("point_cloud")]:
        getattr(away, name)[:] += 50.0
    with pytest.raises(DatasetError, match="no cloud"):
        make_cloud(away)


def test_the_target_of_each_moment_is_the_next_key_frame() -> None:
    """Start -> first key frame, first -> second, and none after the last."""
    examples, demo = _examples(), gliding_demo(0)
    actions = key_frame_actions(demo)
    assert list(examples.step[examples.episode == 0]) == list(range(len(actions)))
    np.testing.assert_array_equal(examples.target[examples.episode == 0], np.stack(actions))
    assert examples.instructions == (SENTENCES, SENTENCES)
    with pytest.raises(DatasetError, match="no demonstrations"):
        make_key_frame_examples([])


def test_poses_come_back_from_their_axes() -> None:
    """Also when the axes are disturbed a little, and turned with a scene."""
    pose = pose_at((0.3, -0.2, 1.0), 2.9, 0.3, -1.0)
    same = pose_from(pose[:3], axes_of(pose))
    np.testing.assert_allclose(same[:3], pose[:3])
    assert abs(same[3:] @ pose[3:]) == pytest.approx(1.0)
    bent = pose_from(pose[:3], axes_of(pose) * 1.3 + 0.01)
    assert abs(bent[3:] @ pose[3:]) > 0.999
    np.testing.assert_allclose(vertical_turn(np.pi / 2) @ [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], atol=1e-12)


def test_two_clusters_of_votes_are_not_averaged() -> None:
    """The cluster that weighs more is taken, although a single vote beside it weighs most."""
    positions = torch.tensor([[[0.0, 0.0, 0.0]] * 3 + [[0.004, 0.0, 0.0]] * 3 + [[0.4, 0.0, 0.0]] * 2])
    weights = torch.tensor([[0.13] * 6 + [0.14, 0.08]]).log()
    axes = torch.tensor([[[1.0, 0.0, 0.0, 0.0, 0.0, -1.0]] * 8])
    position, found = agreed(Votes(weights, positions, axes, torch.zeros(1, 2)))
    np.testing.assert_allclose(position, [0.002, 0.0, 0.0], atol=1e-3)
    np.testing.assert_allclose(found, axes[0, 0], atol=1e-6)


def test_a_few_key_frames_are_learned() -> None:
    """The density at the right poses rises, and the same seed gives the same losses."""
    learner, again = KeyFrameLearner(_examples()), KeyFrameLearner(_examples())
    optimizer = torch.optim.AdamW(learner.network.parameters(), lr=2e-3)
    rng = lambda step: np.random.default_rng([0, step])  # noqa: E731
    assert torch.equal(learner.losses(rng(0), 4)["total"], again.losses(rng(0), 4)["total"])
    found = []
    for step in range(40):
        losses = learner.losses(rng(step), 4)
        optimizer.zero_grad()
        losses["total"].backward()
        torch.nn.utils.clip_grad_norm_(learner.network.parameters(), 1.0)
        optimizer.step()
        found.append(float(losses["pose"].detach()))
    assert np.mean(found[-5:]) < 0.6 * np.mean(found[:3])


def test_models_come_back_and_act(tmp_path: Path) -> None:
    """What was written gives the same weights, and the policy an action of nine finite numbers with a unit quaternion."""
    network = KeyFrameLearner(_examples()).network
    place = tmp_path / "reach_target"
    write_tensors(place / MODEL, network.state_dict())
    write_settings(place / SETTINGS, KIND, {"instructions": list(SENTENCES)})
    loaded = load_key_frames(place)
    assert isinstance(loaded, VoteNetwork) and network.context[0].in_features == CONTEXT
    for name, tensor in network.state_dict().items():
        assert torch.equal(tensor, loaded.state_dict()[name])
    acting = policy(str(tmp_path))
    assert isinstance(acting, Policy)
    acting.reset(SENTENCES[0], PolicyContext("panda", 7, (), (), 0.05, 25, 0))
    action = acting.act(look(BALL))
    assert action.shape == (9,) and np.isfinite(action).all() and np.linalg.norm(action[3:7]) == pytest.approx(1.0)
    assert set(action[7:]) <= {0.0, 1.0}
