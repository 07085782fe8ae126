"""Behaviour cloning: sentences, chunks, files, training that goes on, and a policy that does what it learned."""

from __future__ import annotations

import dataclasses
import json
import threading
from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("tensorboard")

from rlbench_pin.baselines.cloning import (  # noqa: E402
    ChunkLearner,
    ModelFileError,
    TrainConfig,
    load_cloning,
    policy,
    train_cloning,
)
from rlbench_pin.baselines.cloning.model import CHUNK, IMAGE_SIZE, encode_sentence, make_examples, nearest_sentence  # noqa: E402  # noqa: E402
from rlbench_pin.baselines.cloning.training import MODEL, SETTINGS, SHIFT, read_tensors, shifted  # noqa: E402  # noqa: E402
from rlbench_pin.datasets import DatasetWriter  # noqa: E402
from rlbench_pin.errors import DatasetError  # noqa: E402
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext  # noqa: E402
from rlbench_pin.observation import Demo, Observation  # noqa: E402
from tests.baselines.demos_that_reach import FRAMES, SENTENCES, gliding_demo  # noqa: E402

CONTEXT = PolicyContext("panda", 7, (), (), 0.05, 100, 0)
SHORT = TrainConfig(steps=12, batch=8, checkpoint_every=5)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A dataset of six demonstrations."""
    for seed in range(6):
        DatasetWriter(tmp_path / "data", compression="lzf").add(gliding_demo(seed))
    return tmp_path / "data"


def test_sentences_are_told_apart_whatever_their_case() -> None:
    """The vector has length 1, ignores case and stops, and differs where a word does; no word gives no direction."""
    red = encode_sentence("Push the red button.")
    np.testing.assert_array_equal(red, encode_sentence("push THE red button"))
    assert np.linalg.norm(red) == pytest.approx(1.0)
    assert red @ encode_sentence("Push the blue button.") < 0.95
    assert not encode_sentence("...").any()
    assert nearest_sentence("the lamp, switch it on", ["close the drawer", "switch on the lamp"]) == 1


def test_chunks_hold_the_commands_that_follow() -> None:
    """A tick is followed by the commands of the frames after it, and by the last one held; the last frame is no example."""
    demo = gliding_demo(1)
    examples = make_examples([demo, gliding_demo(2)])
    commands = np.stack([o.misc["joint_position_action"] for o in demo[1:]])
    assert examples.targets.shape == (2 * (FRAMES - 1), CHUNK, 7)
    np.testing.assert_array_equal(examples.targets[0], commands[:CHUNK, :7])
    np.testing.assert_array_equal(examples.targets[FRAMES - 2], np.repeat(commands[-1:, :7], CHUNK, axis=0))
    np.testing.assert_array_equal(examples.gripper[FRAMES - 4], np.zeros(CHUNK))
    assert examples.instructions == SENTENCES
    assert examples.time[FRAMES - 2, 0] == pytest.approx(0.05 * (FRAMES - 2))


def test_demonstrations_that_lack_something_are_refused() -> None:
    """No demonstration, no actions, no task state, no images: each is said."""
    with pytest.raises(DatasetError, match="no demonstrations"):
        make_examples([])
    demo = gliding_demo(1)
    del demo[3].misc["joint_position_action"]
    with pytest.raises(DatasetError, match="joint_position_action"):
        make_examples([demo])
    demo = gliding_demo(1)
    demo[2].task_low_dim_state = None
    with pytest.raises(DatasetError, match="task_low_dim_state"):
        make_examples([demo])
    with pytest.raises(DatasetError, match="front"):
        make_examples([gliding_demo(1)], ["front"])


def test_models_remember_the_joints_of_their_demonstrations(tmp_path: Path) -> None:
    """Of every arm but one per model; models without are read as before."""
    names = tuple(f"ur5e_{number}" for number in range(7))
    demos = [gliding_demo(seed) for seed in range(2)]
    assert make_examples(demos).joint_names == ()
    for demo in demos:
        demo.robot, demo.joint_names = "ur5e", names
        DatasetWriter(tmp_path / "data", compression="lzf").add(demo)
    assert train_cloning([tmp_path / "data"], "reach_target", tmp_path / "m", SHORT)
    assert policy(str(tmp_path / "m")).joint_names == names
    path = tmp_path / "m" / "reach_target" / SETTINGS
    path.write_text(json.dumps({k: v for k, v in json.loads(path.read_text()).items() if k != "joint_names"}))
    assert policy(str(tmp_path / "m")).joint_names == ()
    demos[1].robot, demos[1].joint_names = "iiwa", names[::-1]
    with pytest.raises(DatasetError, match="iiwa, ur5e"):
        make_examples(demos)


def test_a_few_demonstrations_are_learned() -> None:
    """The loss falls to a small part of what it was."""
    learner = ChunkLearner(make_examples([gliding_demo(seed) for seed in range(4)]))
    optimizer = torch.optim.AdamW(learner.network.parameters(), lr=1e-3)
    found = []
    for step in range(150):
        losses = learner.losses(np.random.default_rng([0, step]), 64)
        optimizer.zero_grad()
        losses["total"].backward()
        optimizer.step()
        found.append(float(losses["arm"].detach()))
    assert np.mean(found[-10:]) < 0.2 * np.mean(found[:3])


def test_training_that_was_ended_goes_on_to_the_same_weights(root: Path, tmp_path: Path) -> None:
    """Ended between and at checkpoints, then gone on: the file of the model has the same bytes as without."""
    assert train_cloning([root], "reach_target", tmp_path / "a", SHORT)
    for after in (3, 8):
        stop = threading.Event()
        place = tmp_path / f"b{after}"
        on_step = lambda step, loss, n=after, s=stop: s.set() if step == n else None  # noqa: E731
        assert not train_cloning([root], "reach_target", place, SHORT, on_step=on_step, stop=stop)
        assert not (place / "reach_target" / MODEL).exists()
        steps: list[int] = []
        assert train_cloning([root], "reach_target", place, SHORT, on_step=lambda step, _, s=steps: s.append(step))
        assert steps[0] == after + 1
        for name in (MODEL, SETTINGS):
            assert (place / "reach_target" / name).read_bytes() == (tmp_path / "a" / "reach_target" / name).read_bytes()


def test_a_checkpoint_of_other_settings_is_refused(root: Path, tmp_path: Path) -> None:
    """Going on with another learning rate would be neither the one training nor the other."""
    stop = threading.Event()
    stop.set()
    assert not train_cloning([root], "reach_target", tmp_path / "m", SHORT, stop=stop)
    with pytest.raises(ModelFileError, match=r"rate=0\.001"):
        train_cloning([root], "reach_target", tmp_path / "m", dataclasses.replace(SHORT, rate=0.1))
    with pytest.raises(ModelFileError, match="cameras and demonstrations"):
        train_cloning([root], "reach_target", tmp_path / "m", SHORT, demos=1)


def test_the_policy_does_what_was_learned(root: Path, tmp_path: Path) -> None:
    """Played without physics it ends where the task state says, and closes the gripper; twice the same, and from files alone."""
    assert train_cloning([root], "reach_target", tmp_path / "m", TrainConfig(steps=250, batch=64))
    acting = policy(str(tmp_path / "m"))
    assert isinstance(acting, Policy)
    first, second = _played(acting, gliding_demo(2)), _played(policy(str(tmp_path / "m")), gliding_demo(2))
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(_played(acting, gliding_demo(2)), first)
    np.testing.assert_allclose(first[-1, :7], gliding_demo(2)[-1].joint_positions, atol=0.15)
    assert first[0, 7] == 1.0 and first[-1, 7] == 0.0


def _played(acting: Policy, demo: Demo) -> np.ndarray:
    """Return the actions of a policy whose commands are reached at once."""
    acting.reset(SENTENCES[1], CONTEXT)
    observation, actions = demo[0], []
    for _ in range(FRAMES):
        actions.append(acting.act(observation))
        observation = Observation(
            joint_positions=actions[-1][:7], gripper_open=actions[-1][7], task_low_dim_state=demo[0].task_low_dim_state
        )
    return np.stack(actions)


def test_pictures_take_the_place_of_the_state(root: Path, tmp_path: Path) -> None:
    """With cameras, the network has eyes, the policy asks for their colours, and the task state is not looked at."""
    demos = [gliding_demo(seed) for seed in range(2)]
    for demo in demos:
        for frame in demo:
            frame.front_rgb = np.zeros((32, 32, 3), np.uint8)
    DatasetWriter(tmp_path / "seen", compression="lzf").add(demos[0])
    assert train_cloning([tmp_path / "seen"], "reach_target", tmp_path / "m", SHORT, cameras=["front"])
    acting = policy(str(tmp_path / "m"))
    assert acting.obs_config.front_camera.rgb and not acting.obs_config.wrist_camera.rgb
    acting.reset(SENTENCES[0], CONTEXT)
    assert acting.act(Observation(joint_positions=np.zeros(7), gripper_open=1.0, front_rgb=demos[0][0].front_rgb)).shape == (8,)
    assert make_examples(demos, ["front"]).images.shape[1:] == (1, IMAGE_SIZE, IMAGE_SIZE, 3)


def test_pictures_are_moved_by_some_pixels() -> None:
    """Each by its own way, all of it alike; what comes in at a border repeats it."""
    rng = np.random.default_rng(3)
    images = rng.integers(0, 255, size=(6, 2, 12, 12, 3), dtype=np.uint8)
    moved = shifted(images, rng)
    ways = set()
    for before, after in zip(images.reshape(-1, 12, 12, 3), moved.reshape(-1, 12, 12, 3), strict=True):
        padded = np.pad(before, ((SHIFT, SHIFT), (SHIFT, SHIFT), (0, 0)), mode="edge")
        found = [
            (y, x) for y in range(2 * SHIFT + 1) for x in range(2 * SHIFT + 1) if (padded[y : y + 12, x : x + 12] == after).all()
        ]
        assert len(found) == 1
        ways.add(found[0])
    assert len(ways) > 4


def test_damaged_models_are_named(root: Path, tmp_path: Path) -> None:
    """No folder, half a file, and a file of another kind."""
    with pytest.raises(ModelFileError, match="contains no model"):
        policy(str(tmp_path / "nothing"))
    assert train_cloning([root], "reach_target", tmp_path / "m", SHORT)
    model = tmp_path / "m" / "reach_target" / MODEL
    load_cloning(model.parent)
    model.write_bytes(model.read_bytes()[:100])
    with pytest.raises(ModelFileError, match="damaged"):
        load_cloning(model.parent)
    with pytest.raises(ModelFileError, match="does not exist"):
        read_tensors(tmp_path / "none.safetensors")
    settings = tmp_path / "m" / "reach_target" / SETTINGS
    settings.write_text(settings.read_text().replace('"cloning"', '"other"'))
    with pytest.raises(ModelFileError, match="kind"):
        policy(str(tmp_path / "m"))
