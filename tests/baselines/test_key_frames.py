"""Key-frame cloning: clouds, targets, votes, files, and a policy that goes where most votes agree."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("tensorboard")

from rlbench_pin.baselines.cloning.training import MODEL, SETTINGS, write_settings, write_tensors  # noqa: E402
from rlbench_pin.baselines.key_frames import KeyFrameLearner, load_key_frames, policy  # noqa: E402
from rlbench_pin.baselines.key_frames.examples import (  # noqa: E402
    FLAT,
    HIGH,
    LOW,
    NEIGHBOURS,
    OVERVIEW,
    OWN,
    POINT,
    WHOLE,
    Cloud,
    Conditioning,
    Example,
    Frame,
    axes_of,
    demo_examples,
    likeness,
    make_cloud,
    near,
    network_input,
    overview,
    pose_from,
    whole,
)
from rlbench_pin.baselines.key_frames.policy import TRIES, KeyFramePolicy, clusters  # noqa: E402
from rlbench_pin.baselines.key_frames.training import (  # noqa: E402
    COARSE,
    KIND,
    VoteNetwork,
    Votes,
    strongest_neighbour,
)
from rlbench_pin.baselines.perception import arm_surface  # noqa: E402
from rlbench_pin.datasets import key_frames  # noqa: E402
from rlbench_pin.environment import key_frame_actions  # noqa: E402
from rlbench_pin.errors import DatasetError  # noqa: E402
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext  # noqa: E402
from rlbench_pin.observation import Observation  # noqa: E402
from rlbench_pin.robot import RobotModel, robot_description  # noqa: E402
from rlbench_pin.spatial import TABLE_HEIGHT, pose_at  # noqa: E402
from tests.baselines.demos_that_reach import SENTENCES, gliding_demo, look  # noqa: E402

BALL = np.array([0.25, 0.1, TABLE_HEIGHT + 0.2])


@pytest.fixture(scope="module")
def arm() -> RobotModel:
    """The arm of the demonstrations."""
    return RobotModel(robot_description("panda"))


def _examples(arm: RobotModel, count: int = 2) -> list[Example]:
    found = []
    for demo in (gliding_demo(seed) for seed in range(count)):
        found += demo_examples(demo, [look(BALL, i) for i in range(len(key_frames(demo)))], arm)
    return found


def test_a_cloud_shows_things_rather_than_table_and_arm(arm: RobotModel) -> None:
    """All in the box, the table a tenth or a hundred points, none of the arm, twice the same."""
    seen = look(BALL)
    own = arm_surface(arm, np.asarray(seen.joint_positions), np.asarray(seen.gripper_joint_positions))
    assert seen.front_point_cloud is not None
    seen.front_point_cloud[:6] = own[np.resize(np.arange(len(own)), 6 * 24)].reshape(6, 24, 3)
    cloud = make_cloud(seen, arm)
    assert ((cloud.points > LOW) & (cloud.points < HIGH)).all()
    is_table = cloud.points[:, 2] < TABLE_HEIGHT + FLAT
    assert 0 < is_table.sum() <= max(100, 0.1 * (~is_table).sum())
    assert min(np.linalg.norm(own - p, axis=1).min() for p in cloud.points) > OWN - 1e-4
    np.testing.assert_allclose(np.linalg.norm(cloud.points[~is_table] - BALL, axis=1), 0.05, atol=1e-4)
    assert (cloud.colors[~is_table] == (255, 0, 0)).all()
    np.testing.assert_array_equal(make_cloud(seen, arm).points, cloud.points)


def test_without_pictures_there_is_no_cloud(arm: RobotModel) -> None:
    """A camera is missing, or nothing lies in the box."""
    with pytest.raises(DatasetError, match="lacks colours or point clouds"):
        make_cloud(Observation(), arm)
    away = look(BALL)
    for name in [n for n in vars(away) if n.endswith("point_cloud")]:
        getattr(away, name)[:] += 50.0
    with pytest.raises(DatasetError, match="no cloud"):
        make_cloud(away, arm)


def test_near_points_are_those_in_the_ball_or_the_nearest() -> None:
    """Enough in the ball: all chosen are in it, none twice. Too few: the nearest. Fewer than wanted at all: repeated."""
    points = np.linspace(0.0, 1.0, 101)[:, None] * np.array([1.0, 0.0, 0.0])
    rng = np.random.default_rng(0)
    inside = near(points, np.zeros(3), 0.305, 20, rng)
    assert len(set(inside)) == 20 and inside.max() <= 30
    assert sorted(near(points, np.zeros(3), 0.055, 20, rng)) == list(range(20))
    assert len(near(points[:3], np.zeros(3), 0.5, 20, rng)) == 20


def test_a_sight_is_a_sample_in_a_frame_with_the_tip_at_its_end(arm: RobotModel) -> None:
    """The same from a frame that moved with the scene; points are told how like they are to the colours of the sentence."""
    cloud = overview(make_cloud(look(BALL), arm))
    conditioning = Conditioning("Push the blue one, then the red one.", pose_at((0.2, 0.1, 1.0), np.pi, 0.2, 0.3), 1.0, 2)
    sample = whole(cloud, np.random.default_rng(0))
    found = network_input(sample, conditioning, OVERVIEW)
    assert found.points.shape == (WHOLE, POINT) and found.neighbours.shape == (WHOLE, NEIGHBOURS)
    np.testing.assert_allclose(found.points[-1, :3], conditioning.tip[:3] - OVERVIEW.origin, atol=1e-6)
    assert found.points[-1, -1] == 1.0 and not found.points[:-1, -1].any()
    red = (sample.colors == (255, 0, 0)).all(axis=1)
    assert (found.points[:-1][red, 7] > 0.9).all() and (found.points[:-1][red, 6] < 0.1).all()
    rotation, shift = pin.exp3(np.array([0.0, 0.0, 0.4])), np.array([0.1, -0.2, 0.0])
    tip = pose_from(rotation @ conditioning.tip[:3] + shift, (axes_of(conditioning.tip).reshape(2, 3) @ rotation.T).ravel())
    moved = Cloud((sample.points @ rotation.T + shift).astype(np.float32), sample.colors)
    frame = Frame(rotation @ OVERVIEW.origin + shift, rotation)
    same = network_input(moved, Conditioning(conditioning.sentence, tip, 1.0, 2), frame)
    np.testing.assert_allclose(same.points, found.points, atol=1e-5)
    np.testing.assert_allclose(same.context, found.context, atol=1e-6)


def test_colours_of_a_sentence_keep_their_order() -> None:
    """The first column is about the first colour that is named, columns without a colour are zero."""
    like = likeness(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), "Blue, then red.")
    assert like[1, 0] > 0.9 > 0.2 > like[0, 0] and like[0, 1] > 0.9 > 0.2 > like[1, 1]
    assert not like[:, 2:].any()


def test_the_target_of_each_moment_is_the_next_key_frame(arm: RobotModel) -> None:
    """Start -> first key frame, first -> second, and none after the last."""
    examples, demo = _examples(arm, 1), gliding_demo(0)
    actions = key_frame_actions(demo)
    assert [e.step for e in examples] == list(range(len(actions)))
    np.testing.assert_array_equal([e.target for e in examples], np.stack(actions))
    assert examples[0].sentences == SENTENCES
    with pytest.raises(DatasetError, match="no demonstrations"):
        KeyFrameLearner([])


def test_poses_come_back_from_their_axes() -> None:
    """Also when the axes are disturbed a little, and turned with a scene."""
    pose = pose_at((0.3, -0.2, 1.0), 2.9, 0.3, -1.0)
    same = pose_from(pose[:3], axes_of(pose))
    np.testing.assert_allclose(same[:3], pose[:3])
    assert abs(same[3:] @ pose[3:]) == pytest.approx(1.0)
    bent = pose_from(pose[:3], axes_of(pose) * 1.3 + 0.01)
    assert abs(bent[3:] @ pose[3:]) > 0.999
    frame = Frame.of_tip(pose_at((0.1, 0.2, 0.3), 0.4, -0.5, 0.6))
    back = frame.pose(frame.points(pose[:3]), frame.axes(axes_of(pose)))
    np.testing.assert_allclose(back[:3], pose[:3])
    assert abs(back[3:] @ pose[3:]) == pytest.approx(1.0)


def test_two_clusters_of_votes_are_not_averaged() -> None:
    """The cluster that weighs more is taken, although a single vote beside it weighs most."""
    positions = torch.tensor([[[0.0, 0.0, 0.0]] * 3 + [[0.004, 0.0, 0.0]] * 3 + [[0.4, 0.0, 0.0]] * 2])
    weights = torch.tensor([[0.13] * 6 + [0.14, 0.08]]).log()
    axes = torch.tensor([[[1.0, 0.0, 0.0, 0.0, 0.0, -1.0]] * 8])
    (position, found), (other, _) = clusters(Votes(weights, positions, axes, torch.zeros(1, 2), COARSE))
    np.testing.assert_allclose(position, [0.002, 0.0, 0.0], atol=1e-3)
    np.testing.assert_allclose(found, axes[0, 0], atol=1e-6)
    np.testing.assert_allclose(other, [0.4, 0.0, 0.0], atol=1e-3)


def test_the_strongest_neighbour_is_found_and_gets_the_gradient() -> None:
    """As a plain maximum over the gathered rows does."""
    generator = torch.Generator().manual_seed(0)
    values = torch.randn(2, 30, 5, generator=generator).requires_grad_()
    rows = torch.randint(0, 30, (2, 30, 8), generator=generator)
    plain = torch.stack([v[r].amax(dim=1) for v, r in zip(values, rows, strict=True)])
    found = strongest_neighbour(values, rows)
    assert torch.equal(plain, found)
    (gradient,) = torch.autograd.grad(found.square().sum(), values)
    expected = torch.zeros_like(values)
    for clouds in range(2):
        for point in range(30):
            for column in range(5):
                row = rows[clouds, point, values[clouds, rows[clouds, point], column].argmax()]
                expected[clouds, row, column] += 2.0 * found[clouds, point, column]
    torch.testing.assert_close(gradient, expected)


def test_a_few_key_frames_are_learned(arm: RobotModel) -> None:
    """The density at the right poses rises, and the same seed gives the same losses."""
    examples = _examples(arm)
    learner, again = KeyFrameLearner(examples), KeyFrameLearner(examples)
    optimizer = torch.optim.AdamW(learner.network.parameters(), lr=2e-3)
    rng = lambda step: np.random.default_rng([0, step])  # noqa: E731
    assert torch.equal(learner.losses(rng(0), 4)["total"], again.losses(rng(0), 4)["total"])
    found = []
    for step in range(16):
        losses = learner.losses(rng(step), 2)
        optimizer.zero_grad()
        losses["total"].backward()
        torch.nn.utils.clip_grad_norm_(learner.network.parameters(), 1.0)
        optimizer.step()
        found.append([float(losses[name].detach()) for name in ("coarse", "fine")])
    assert (np.mean(found[-4:], axis=0) < 0.7 * np.mean(found[:3], axis=0)).all()


@pytest.fixture
def acting(tmp_path: Path) -> KeyFramePolicy:
    """The policy of networks that learned nothing, of a task with two key frames."""
    networks = KeyFrameLearner(_examples(RobotModel(robot_description("panda")), 1)).network
    place = tmp_path / "reach_target"
    write_tensors(place / MODEL, networks.state_dict())
    write_settings(place / SETTINGS, KIND, {"key_frames": dict.fromkeys(SENTENCES, 2), "joint_names": ["a", "b"]})
    loaded = load_key_frames(place)
    assert all(isinstance(network, VoteNetwork) for network in loaded.values())
    for name, tensor in networks.state_dict().items():
        assert torch.equal(tensor, loaded.state_dict()[name])
    return policy(str(tmp_path))


def test_models_come_back_and_act(acting: KeyFramePolicy) -> None:
    """An action of nine finite numbers with a unit quaternion, twice the same."""
    assert isinstance(acting, Policy) and acting.joint_names == ("a", "b")
    actions = []
    for _ in range(2):
        acting.reset(SENTENCES[0], PolicyContext("panda", 7, (), (), 0.05, 25, 0))
        actions.append(acting.act(look(BALL)))
    action = actions[0]
    assert action.shape == (9,) and np.isfinite(action).all() and np.linalg.norm(action[3:7]) == pytest.approx(1.0)
    assert set(action[7:]) <= {0.0, 1.0}
    np.testing.assert_array_equal(actions[0], actions[1])


def test_what_is_refused_is_not_asked_for_again(acting: KeyFramePolicy) -> None:
    """Joints that did not move: another pose, until it gives up on that key frame. All done: back to the start, and again."""
    acting.reset(SENTENCES[0], PolicyContext("panda", 7, (), (), 0.05, 25, 0))
    seen = look(BALL)
    asked = [acting.act(seen)[:7] for _ in range(TRIES + 1)]
    assert all(np.abs(a - b).max() > 1e-6 for a, b in zip(asked, asked[1:]))

    def moved() -> Observation:
        seen.joint_positions = np.asarray(seen.joint_positions) + 0.01
        seen.gripper_pose = np.asarray(seen.gripper_pose) + (0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        return seen

    home = look(BALL).gripper_pose
    assert home is not None
    assert np.abs(acting.act(moved())[:7] - home).max() > 1e-3
    np.testing.assert_allclose(acting.act(moved()), [*home, 1.0, 0.0])
    assert np.abs(acting.act(moved())[:7] - home).max() > 1e-3
