"""Someone who trains for the real world: textures of their own on everything, every episode or every variation."""

import os
import tempfile

import numpy as np
from PIL import Image

from rlbench import Environment, ObservationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.tasks import OpenDrawer


def make_textures(folder, count=6):
    random = np.random.RandomState(0)
    for i in range(count):
        tile = random.randint(0, 255, (4, 4, 3)).astype(np.uint8)
        Image.fromarray(tile).resize((64, 64), Image.NEAREST).save(os.path.join(folder, "texture%d.png" % i))


def environment(config, every, frequency=1):
    obs_config = ObservationConfig()
    obs_config.set_all(False)
    obs_config.front_camera.rgb = True
    obs_config.front_camera.mask = True
    obs_config.front_camera.image_size = (64, 64)
    return Environment(
        MoveArmThenGripper(JointVelocity(), Discrete()),
        "",
        obs_config,
        True,
        static_positions=True,
        randomize_every=every,
        frequency=frequency,
        visual_randomization_config=config,
    )


def images(env, count):
    env.launch()
    task = env.get_task(OpenDrawer)
    task.set_variation(0)
    out = []
    for _ in range(count):
        _, obs = task.reset()
        obs, _, _ = task.step([0.0] * 7 + [1.0])
        out.append(obs.front_rgb.astype(float))
    env.shutdown()
    return out


def changed(a, b):
    return float((np.abs(a - b).max(axis=2) > 12).mean())


def main():
    np.random.seed(11)
    with tempfile.TemporaryDirectory() as folder:
        try:
            VisualRandomizationConfig(os.path.join(folder, "nowhere"))
        except NotADirectoryError as error:
            print("as expected:", error)
        try:
            VisualRandomizationConfig(folder)
        except RuntimeError as error:
            print("as expected:", error)
        make_textures(folder)
        config = VisualRandomizationConfig(image_directory=folder)
        assert len(config.sample(3)) == 3 and all(os.path.exists(path) for path in config.sample(3))

        plain = images(environment(None, None), 2)
        every = images(environment(config, RandomizeEvery.EPISODE), 3)
        second = images(environment(config, RandomizeEvery.EPISODE, frequency=2), 4)
    assert changed(plain[0], plain[1]) < 0.02, changed(plain[0], plain[1])
    assert changed(plain[0], every[0]) > 0.3, changed(plain[0], every[0])
    assert changed(every[0], every[1]) > 0.3 and changed(every[1], every[2]) > 0.3
    kept = [changed(a, b) for a, b in zip(second, second[1:])]
    assert sorted(kept)[0] < 0.05 and max(kept) > 0.3, kept
    print(
        "appearance changed on %.0f %% of the pixels; with frequency 2: %s"
        % (100 * changed(every[0], every[1]), np.round(kept, 2))
    )


if __name__ == "__main__":
    main()
