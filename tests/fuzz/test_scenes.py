"""Scene files of all kinds are read into a scene that can be built and reset, or refused with the place that is wrong."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin import tasks
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import robot_description
from rlbench_pin.scene import SceneSpec, read_scene
from rlbench_pin.sim import World
from tests.fuzz.cases import Case, Tally
from tests.fuzz.mutations import TEXTS, changed, damaged, toml_text

LIBRARY = sorted((Path(tasks.__file__).parent / "library").glob("*.toml"))


def built(path: Path) -> object:
    """Read a scene, build its world, and let a tick pass."""
    scene = read_scene(path)
    with World(scene, robot_description("panda")) as world:
        world.step()
        return [body.pose for body in world.bodies.values()]


def holds_together(scene: object) -> str:
    """Say what is wrong with a scene that was read: numbers that are none, or parents that are not there."""
    assert isinstance(scene, SceneSpec)
    for thing in (*scene.body, *scene.frame, *scene.region, *scene.sensor, *scene.waypoint):
        if not np.isfinite(thing.pose).all() or np.abs(thing.pose[:3]).max() > 1e6:
            return f"the pose of {thing.name} is {thing.pose}"
    return ""


def try_scenes(tally: Tally, folder: Path, seed: int, count: int, build: float) -> None:
    """Change every scene file of the library `count` times, and read it; build a share of those that are read."""
    path = folder / "scene.toml"
    for number, source in enumerate(LIBRARY):
        rng = np.random.default_rng((seed, number))
        text = source.read_text()
        tree = tomllib.loads(text)
        for k in range(count):
            words = f"{source.stem}, change {k} of seed {seed}"
            if k % 8 == 6:
                path.write_bytes(damaged(text.encode(), rng))
            elif k % 8 == 7:
                path.write_text(TEXTS[int(rng.integers(len(TEXTS)))](text), errors="replace")
            else:
                path.write_text(toml_text(changed(tree, rng)), errors="replace")
            tally.run(Case("read_scene", words, lambda: read_scene(path), check_result=holds_together, finite=False))
            if rng.random() < build and _is_read(path):
                tally.run(Case("World of a scene", words, lambda: built(path)))
    assert not tally.faults, f"seed {seed}:\n{tally.report()}"


def _is_read(path: Path) -> bool:
    try:
        read_scene(path)
    except RlbenchPinError:
        return False
    return True


@pytest.mark.simulation
def test_scene_files(tally: Tally, seed: int, elsewhere: Path) -> None:
    """A few changes of each."""
    try_scenes(tally, elsewhere, seed, 16, 0.0)
    assert tally.cases > 500


@pytest.mark.slow
def test_scene_files_many_times(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Many changes of each; some of the worlds are built."""
    try_scenes(tally, elsewhere, seed, 90, 0.1)
    assert tally.cases > 3_000
    assert tally.doors["World of a scene"] > 20
