"""Domain randomization, noise and render modes under the known names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pyrep.const import RenderMode
from rlbench import CameraConfig, Environment, ObservationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.noise_model import GaussianNoise, Identity, NoiseModel
from rlbench.observation_config import CameraConfig as SameCameraConfig
from rlbench.sim2real.domain_randomization import DynamicsRandomizationConfig, Gaussian, RandomizationConfig, Uniform
from rlbench.sim2real.domain_randomization_scene import DomainRandomizationScene
from rlbench.tasks import OpenDrawer, ReachTarget

pytestmark = pytest.mark.simulation

REST = [0.0] * 7 + [1.0]


class Offset(NoiseModel):
    """Adds a fixed number; takes one argument, as programs write it."""

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Add."""
        return val + 0.25


def settings(**camera: object) -> ObservationConfig:
    """A small front camera, and joints."""
    config = ObservationConfig(front_camera=CameraConfig(image_size=(48, 32), **camera))  # type: ignore[arg-type]
    for name in ("left_shoulder", "right_shoulder", "overhead", "wrist"):
        config.camera(name).set_all(False)
    return config


def make(config: ObservationConfig, **others: object) -> Environment:
    """An environment of joint velocities, everything at its nominal place."""
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    return Environment(mode, "", config, True, True, "panda", **others)  # type: ignore[arg-type]


@pytest.fixture
def textures(tmp_path: Path) -> Path:
    """Four textures of one colour each."""
    for index, colour in enumerate(((255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0))):
        Image.new("RGB", (16, 16), colour).save(tmp_path / f"{index}.png")
    return tmp_path


def share_changed(a: np.ndarray | None, b: np.ndarray | None) -> float:
    """Return the share of pixels that differ clearly."""
    assert a is not None and b is not None
    return float((np.abs(a.astype(int) - b).max(axis=2) > 12).mean())


def test_looks_change_with_every_episode(textures: Path) -> None:
    """Positional arguments as programs pass them; the black list spares the room under its known names."""
    visual = VisualRandomizationConfig(str(textures), None, ["Floor", "Roof", "Wall?", "diningTable_visible"], False)
    assert visual.should_randomize("chest") and not visual.should_randomize("table") and not visual.should_randomize("floor")
    assert len(visual.sample(5)) == 5
    everything = VisualRandomizationConfig(str(textures))
    images = {}
    for name, config in (("spared", visual), ("all", everything)):
        env = make(settings(), randomize_every=RandomizeEvery.EPISODE, frequency=1, visual_randomization_config=config)
        task = env.get_task(OpenDrawer)
        assert isinstance(task._scene, DomainRandomizationScene)
        np.random.seed(4)
        images[name] = [task.reset()[1].front_rgb for _ in range(3)]
        env.shutdown()
    spared = max(share_changed(images["spared"][0], other) for other in images["spared"][1:])
    everywhere = max(share_changed(images["all"][0], other) for other in images["all"][1:])
    assert 0.0 < spared < 0.35 < everywhere


def test_white_lists_and_other_names() -> None:
    """A white list alone restricts; the placeholders draw from numpy's global generator."""
    only = RandomizationConfig(["chest"], None, False)
    assert only.should_randomize("chest") and not only.should_randomize("table")
    np.random.seed(0)
    assert Gaussian(0.1).apply(np.zeros(3)).std() > 0.0
    assert np.all(np.abs(Uniform(-1.0, 1.0).apply(np.zeros(100))) <= 1.0)


def test_dynamics_change() -> None:
    """Dynamics randomization is at work, where others only accept it."""
    dynamics = DynamicsRandomizationConfig(mass=(2.0, 2.0))
    env = make(settings(), randomize_every=RandomizeEvery.EPISODE, dynamics_randomization_config=dynamics)
    task = env.get_task(ReachTarget)
    task.reset()
    task.step(REST)
    env.shutdown()


def test_noise_of_programs_and_of_the_package() -> None:
    """Noise models take one argument and draw from numpy's global generator."""
    config = settings(rgb_noise=Offset(), depth_noise=GaussianNoise(0.01), depth_in_meters=True)
    config.joint_positions_noise = GaussianNoise(0.1, (-3.0, 3.0))
    config.joint_velocities_noise = Offset()
    plain = settings(depth_in_meters=True)
    first, second, clean = (_observe(c, 5) for c in (config, config, plain))
    assert np.array_equal(first.joint_positions, second.joint_positions)
    assert 0.01 < np.abs(first.joint_positions - clean.joint_positions).max() < 1.0
    assert np.allclose(first.joint_velocities, clean.joint_velocities + 0.25, atol=1e-6)
    assert first.front_rgb.mean() > clean.front_rgb.mean() + 20
    assert 1e-4 < np.abs(first.front_depth - clean.front_depth).mean() < 0.02
    assert np.array_equal(Identity().apply(clean.joint_positions), clean.joint_positions)
    with pytest.raises(NotImplementedError):
        NoiseModel().apply(np.zeros(2))


def _observe(config: ObservationConfig, seed: int) -> Any:
    env = make(config)
    task = env.get_task(ReachTarget)
    np.random.seed(seed)
    observation = task.reset()[1]
    env.shutdown()
    return observation


def test_render_modes() -> None:
    """OPENGL draws no shadows, OPENGL3 does; what cannot be drawn is refused when the scene is made."""
    without, with_shadows = (_observe(settings(render_mode=mode), 1) for mode in (RenderMode.OPENGL, RenderMode.OPENGL3))
    assert 0.0 < share_changed(without.front_rgb, with_shadows.front_rgb) < 0.5
    env = make(settings(render_mode=RenderMode.POV_RAY))
    with pytest.raises(Exception, match="OPENGL3"):
        env.launch()
    assert SameCameraConfig is CameraConfig
