"""Few-shot by replay: scenes are brought together, key frames are moved with them, the nearest demonstration is taken."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.baselines.few_shot import FAR, PlanarMotion, Scene, kept_mean, thinned, words_of
from rlbench_pin.spatial import pose_at


def corner(rng: np.random.Generator, red: float = 0.03) -> np.ndarray:
    """An L of 15 by 10 cm, 4 cm high, that no turn brings onto itself, (n, 6)."""
    long = rng.uniform((0.0, 0.0, 0.8), (0.15, 0.03, 0.84), (250, 3))
    short = rng.uniform((0.0, 0.0, 0.8), (0.03, 0.1, 0.84), (200, 3))
    places = np.concatenate([long, short])
    return np.column_stack([places, np.full(len(places), red), np.zeros((len(places), 2))])


@pytest.mark.parametrize("seed", range(4))
def test_a_scene_is_found_again(seed: int) -> None:
    """After any turn and shift, seen by other points: to 4 mm and 4 degrees."""
    rng = np.random.default_rng(seed)
    truth = PlanarMotion(float(rng.uniform(-3.0, 3.0)), *(float(v) for v in rng.uniform(-0.2, 0.2, 2)))
    match = Scene(truth.of_points(corner(rng))).whole(shown := corner(rng))
    errors = match.motion.of_points(shown) - truth.of_points(shown)
    assert np.linalg.norm(errors, axis=1).max() < 0.01
    assert abs(np.angle(np.exp(1j * (match.motion.yaw - truth.yaw)))) < np.radians(4.0)


def test_a_part_is_found_among_others() -> None:
    """Its colour tells it from another thing of the same shape, wherever that stands."""
    rng = np.random.default_rng(0)
    red, blue = PlanarMotion(0.4, 0.3, 0.2), PlanarMotion(-0.7, 0.1, -0.3)
    other = corner(rng, red=0.0)
    scene = Scene(np.concatenate([blue.of_points(other), red.of_points(corner(rng))]))
    match = scene.part(part := corner(rng), PlanarMotion())
    assert np.linalg.norm(match.motion.of_points(part) - red.of_points(part), axis=1).max() < 0.015


def test_poses_and_points_move_alike() -> None:
    """The tip stays where it is on the thing, and turns with it."""
    motion = PlanarMotion.about(0.5, np.array([0.2, 0.1]), np.array([-0.1, 0.3]))
    pose = motion.of_pose(pose_at((0.2, 0.1, 0.9), yaw=0.2))
    assert pose[:3] == pytest.approx([-0.1, 0.3, 0.9])
    assert pose == pytest.approx(pose_at((-0.1, 0.3, 0.9), yaw=0.7))
    moved = motion.of_points(np.array([[0.2, 0.1, 0.9, 0.1, 0.2, 0.3]]))
    assert moved[0] == pytest.approx([-0.1, 0.3, 0.9, 0.1, 0.2, 0.3])


def test_small_things() -> None:
    """The worst distances do not count, points are thinned evenly, words are compared without their case."""
    assert kept_mean(np.array([0.01, 0.01, 0.01, 0.01, np.inf])) == pytest.approx(0.01)
    assert kept_mean(np.array([np.inf])) == FAR
    assert len(thinned(np.zeros((7, 6)), 3)) == 3
    assert words_of("Push the Red button!") == {"push", "the", "red", "button"}
