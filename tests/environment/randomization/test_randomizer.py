"""Domain randomization: when, what, the same again from the same seed, and gone when it is over."""

from __future__ import annotations

import gc

import numpy as np
import psutil
import pytest

from rlbench_pin.environment import (
    CameraConfig,
    Discrete,
    DynamicsRandomizationConfig,
    Environment,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench_pin.errors import CameraError
from rlbench_pin.observation import CAMERAS

STILL = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


def environment(every=None, visual=None, dynamics=None, size=(32, 32), **keys) -> Environment:
    """The front camera, small."""
    config = ObservationConfig()
    for name in CAMERAS:
        config.cameras()[name].set_all(name == "front")
    config.front_camera.image_size = size
    return Environment(
        MoveArmThenGripper(JointVelocity(), Discrete()),
        obs_config=config,
        randomize_every=every,
        visual_randomization_config=visual,
        dynamics_randomization_config=dynamics,
        seed=0,
        **keys,
    )


def differ(a, b) -> bool:
    """Whether most pixels differ."""
    return bool((a.front_rgb != b.front_rgb).any(axis=2).mean() > 0.5)


def test_textures_are_drawn_with_or_without_a_generator():
    """`sample(n)` gives n images of the folder; with a generator they are the same for the same seed."""
    config = VisualRandomizationConfig()
    drawn = config.sample(5)
    assert len(drawn) == 5
    assert all(path.parent == config.image_directory and path.is_file() for path in drawn)
    assert len({tuple(config.sample(5)) for _ in range(20)}) > 1
    assert config.sample(5, np.random.default_rng(1)) == config.sample(samples=5, rng=np.random.default_rng(1))
    assert config.sample(0) == []


@pytest.mark.simulation
def test_events_are_distinct():
    """EPISODE changes at each reset, VARIATION when the variation changes, TRANSITION within an episode."""
    assert len({every.value for every in RandomizeEvery}) == 3
    config = VisualRandomizationConfig()
    with environment(RandomizeEvery.EPISODE, config) as env:
        task = env.get_task("reach_target")
        a, b = task.reset(seed=0, variation=0)[1], task.reset(seed=1, variation=0)[1]
        assert differ(a, b) and not differ(b, task.step(STILL)[0])
        np.testing.assert_array_equal(task.reset(seed=0, variation=0)[1].front_rgb, a.front_rgb)
    with environment(RandomizeEvery.VARIATION, config) as env:
        task = env.get_task("reach_target")
        a, b = task.reset(seed=0, variation=0)[1], task.reset(seed=1, variation=0)[1]
        assert not differ(a, b) and differ(b, task.reset(seed=1, variation=1)[1])
    with environment(RandomizeEvery.TRANSITION, config, frequency=2) as env:
        task = env.get_task("reach_target")
        seen = [task.reset(seed=0)[1], *(task.step(STILL)[0] for _ in range(4))]
        assert [differ(a, b) for a, b in zip(seen, seen[1:])] == [True, False, True, False]


def test_frequency_counts_episodes():
    """The first and then every second reset brings a new look."""
    with environment(RandomizeEvery.EPISODE, VisualRandomizationConfig(), frequency=2) as env:
        task = env.get_task("reach_target")
        seen = [task.reset(seed=i, variation=0)[1] for i in range(4)]
    assert [differ(a, b) for a, b in zip(seen, seen[1:])] == [False, True, False]


@pytest.mark.parametrize(
    ("keys", "allowed", "forbidden"),
    [
        ({}, ("table", "panda"), ()),
        ({"whitelist": ["wall_*"]}, ("wall_front",), ("table", "panda")),
        ({"blacklist": ["table"]}, ("floor", "panda"), ("table",)),
        ({"whitelist": ["table", "floor"], "blacklist": ["floor"]}, ("table",), ("floor", "wall_front")),
    ],
)
def test_white_and_black_lists_work(keys, allowed, forbidden):
    """A thing changes when it is on the white list, if there is one, and not on the black one."""
    config = VisualRandomizationConfig(**keys)
    assert all(config.should_randomize(name) for name in allowed)
    assert not any(config.should_randomize(name) for name in forbidden)


def test_the_arm_can_be_left_alone():
    """Without `randomize_arm` no link of the robot gets a texture."""
    for randomize_arm in (True, False):
        with environment(RandomizeEvery.EPISODE, VisualRandomizationConfig(randomize_arm=randomize_arm)) as env:
            task = env.get_task("reach_target")
            task.reset(seed=0)
            assert bool(task._changes.current.links) == randomize_arm


@pytest.mark.simulation
def test_after_randomization_everything_is_as_before():
    """Randomized appearance and dynamics leave nothing behind: images and physics have the same bytes afterwards."""

    def run(task) -> bytes:
        task.reset(seed=7, variation=0)
        move = np.array([0.2, 0.3, -0.2, -0.3, 0.2, 0.3, -0.2, 1.0])
        last = [task.step(move)[0] for _ in range(8)][-1]
        return b"".join(np.asarray(v).tobytes() for _, v in sorted(vars(last).items()) if isinstance(v, np.ndarray))

    with environment() as env:
        expected = run(env.get_task("pick_and_lift"))
    config = VisualRandomizationConfig(camera_shift=0.02, camera_turn=0.02)
    with environment(RandomizeEvery.EPISODE, config, DynamicsRandomizationConfig()) as env:
        task = env.get_task("pick_and_lift")
        assert run(task) != expected
        task._changes.remove()
        task._changes = None
        assert run(task) == expected


def test_dynamics_change_motion_and_stay_within_bounds():
    """Masses, friction, damping and gains are drawn inside their bounds and change what happens."""
    config = DynamicsRandomizationConfig(mass=(0.5, 2.0), gains=(0.3, 0.4))
    with environment(RandomizeEvery.EPISODE, dynamics=config) as env:
        task = env.get_task("pick_and_lift")
        task.reset(seed=0)
        sample = task._changes.current
        assert all(0.5 <= mass <= 2.0 for mass, _, _ in sample.dynamics.values())
        assert 0.3 <= sample.gains <= 0.4 and task.world.robot.position_gain == 0.2 * sample.gains


def test_states_keep_their_look():
    """Going back to a state brings its look back."""
    with environment(RandomizeEvery.TRANSITION, VisualRandomizationConfig()) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        before, state = task.step(STILL)[0], task.get_state()
        assert differ(before, task.step(STILL)[0])
        np.testing.assert_array_equal(task.set_state(state).front_rgb, before.front_rgb)


@pytest.mark.simulation
def test_states_with_fewer_bodies_come_back():
    """A state comes back in which a body of the sample is gone already, as stains are that were wiped off."""
    with environment(RandomizeEvery.EPISODE, VisualRandomizationConfig(), DynamicsRandomizationConfig()) as env:
        task = env.get_task("wipe_desk")
        task.reset(seed=0)
        full, sample = task.get_state(), task._changes.current
        assert "stain7" in sample.dynamics and "table" in sample.dynamics
        task._runtime.task.stains.remove("stain7")
        task.world.remove_body("stain7")
        state = task.get_state()
        task.set_state(full)
        assert "stain7" in task.world.bodies
        task.set_state(state)
        assert "stain7" not in task.world.bodies and task._changes.current is sample
        for name in ("table", "sponge"):
            uid = task.world.body(name).model.uid
            assert any(changed == uid for changed, _ in task.world.dynamics_overrides._changed)


def test_mistakes_are_refused(tmp_path):
    """Missing folders, folders without images, broken images, configs without an event."""
    with pytest.raises(NotADirectoryError):
        VisualRandomizationConfig(tmp_path / "missing")
    with pytest.raises(RuntimeError):
        VisualRandomizationConfig(tmp_path)
    (tmp_path / "broken.png").write_bytes(b"no image")
    with (
        environment(RandomizeEvery.EPISODE, VisualRandomizationConfig(tmp_path)) as env,
        pytest.raises(CameraError, match="broken"),
    ):
        env.get_task("reach_target").reset(seed=0)
    with pytest.raises(ValueError):
        environment(RandomizeEvery.EPISODE)
    with pytest.raises(ValueError):
        environment(None, VisualRandomizationConfig())
    for frequency in (0, True, 2.0, "2", np.timedelta64(2, "s")):
        with pytest.raises(ValueError, match="frequency"):
            environment(RandomizeEvery.EPISODE, VisualRandomizationConfig(), frequency=frequency)
    with pytest.raises(ValueError):
        DynamicsRandomizationConfig(mass=(2.0, 1.0))


@pytest.mark.simulation
def test_ten_environments_do_not_disturb_each_other():
    """Ten environments in one process, used in turns, give what each gives alone."""
    environments = [environment(RandomizeEvery.EPISODE, VisualRandomizationConfig()) for _ in range(10)]
    tasks = [env.get_task("reach_target") for env in environments]
    together = [task.reset(seed=i, variation=0)[1].front_rgb for i, task in enumerate(tasks)]
    for env in environments:
        env.shutdown()
    with environment(RandomizeEvery.EPISODE, VisualRandomizationConfig()) as env:
        task = env.get_task("reach_target")
        for i in (9, 0, 4):
            np.testing.assert_array_equal(task.reset(seed=i, variation=0)[1].front_rgb, together[i])


@pytest.mark.slow
def test_two_hundred_randomized_episodes_need_no_more_memory():
    """All cameras, visual randomization: memory grows by less than 3 % after the first 40 episodes, and no frame is black."""
    env = environment(RandomizeEvery.EPISODE, VisualRandomizationConfig(camera_shift=0.01))
    with env:
        for name in CAMERAS:
            env._obs_config.cameras()[name].set_all(True)
            env._obs_config.cameras()[name].image_size = CameraConfig().image_size
        task = env.get_task("stack_blocks")
        process, start = psutil.Process(), 0
        for episode in range(200):
            observation = task.reset(seed=episode)[1]
            assert all(getattr(observation, f"{name}_rgb").mean() > 10 for name in CAMERAS)
            if episode == 40:
                gc.collect()
                start = process.memory_info().rss
        gc.collect()
        assert process.memory_info().rss < 1.03 * start


@pytest.mark.slow
def test_a_hundred_launches_leak_nothing():
    """Launch, one image, shutdown: memory grows by less than 3 % after the first 20; files, threads and children not at all."""
    process, start, handles = psutil.Process(), 0, (0, 0, 0)
    for cycle in range(100):
        with environment() as env:
            env.get_task("reach_target").reset(seed=0)
        gc.collect()  # a closed environment consists of reference cycles, so its memory is free only now
        if cycle == 20:
            start, handles = process.memory_info().rss, _handles(process)
    assert process.memory_info().rss < 1.03 * start
    assert _handles(process) == handles


def _handles(process: psutil.Process) -> tuple[int, int, int]:
    """Open files, threads and children of a process."""
    return process.num_fds(), process.num_threads(), len(process.children())
