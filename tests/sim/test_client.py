"""The client of a physics server: the journal of its calls, and what C libraries print."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.sim.client import Journal, bullet
from rlbench_pin.sim.output import captured_output
from rlbench_pin.tasks import task_class, task_names, task_scene
from tests.sim.support import PANDA, build, close_on_cube, cube, cube_scene, furniture_scene, steps

NOT_RECORDED = ("connect", "get", "setPhysicsEngineParameter")
"""Beginnings of functions that need not be repeated; the last is also called to empty a cache of files."""


def built(make: Callable[[], World]) -> tuple[World, list[str]]:
    """A world, and the names of all functions of PyBullet that were called to make it."""
    names: list[str] = []

    def listen(frame: object, event: str, function: object) -> None:
        if event == "c_call" and getattr(function, "__self__", None) is bullet:
            names.append(function.__name__)

    sys.setprofile(listen)
    try:
        world = make()
    finally:
        sys.setprofile(None)
    return world, names


def task_world(name: str) -> World:
    """The world of a task, after the task has prepared it."""
    chosen = task_class(name)
    world = World(task_scene(chosen), PANDA)
    chosen(world).init_task()
    return world


def changes(names: list[str]) -> list[str]:
    """Names of those functions that change a world."""
    return [name for name in names if not name.startswith(NOT_RECORDED)]


@pytest.mark.parametrize("name", task_names())
def test_all_that_builds_the_world_of_a_task_is_recorded(name):
    """Every call that changes the world, in the right order: none goes past the journal."""
    world, names = built(lambda: task_world(name))
    with world:
        recorded = [change.function.__name__ for change in world.client.journal.changes]
        assert "loadURDF" in names and "getNumJoints" in names
        assert changes(recorded) == changes(names)
        assert recorded.count("setPhysicsEngineParameter") == 1


def prepared() -> World:
    """A world in which everything was changed that a task can change before the first step."""
    world = build(furniture_scene())
    world.add_body("first", cube("any", 0.4, 0.3))
    world.add_body("second", cube("any", 0.5, 0.3))
    world.remove_body("first")
    world.body("second").set_color((0.1, 0.2, 0.3))
    world.body("second").set_colors({})
    world.body("cube").set_collides(False)
    world.body("cube").set_velocity([0.1, 0, 0, 0, 0, 0])
    world.joint("chest/drawer_top").lock()
    world.joint("chest/drawer_middle").unlock()
    world.joint("chest/drawer_middle").set_position(0.02)
    world.robot.set_joint_states(*world.robot.joint_states()[:2])
    world.place_root(world.root.pose + [0.05, 0, 0, 0, 0, 0, 0])
    world.gripper.grasp("second")
    world.gripper.release()
    return world


def test_all_that_a_task_may_prepare_is_recorded():
    """Bodies added and removed, colours, collisions, locks, grasps and places are part of the building."""
    world, names = built(prepared)
    with world:
        assert {"removeBody", "changeVisualShape", "setCollisionFilterGroupMask", "removeConstraint"} <= set(names)
        assert changes([change.function.__name__ for change in world.client.journal.changes]) == changes(names)


def test_nothing_is_recorded_once_the_world_is_built():
    """The first step ends the building."""
    with build(cube_scene()) as world:
        steps(world, 1)
        before = world.client.journal.changes
        close_on_cube(world)
        world.gripper.grasp("cube")
        world.body("cube").set_color((0.1, 0.2, 0.3))
        assert world.client.journal.changes == before


def test_two_clients_keep_their_own_journals():
    """What is done to one world is not repeated in another."""
    with build(SceneSpec(format=1)) as one, build(SceneSpec(format=1)) as two:
        before = two.client.journal.changes
        one.add_body("late", cube("late", 0.4, 0.2, 0.9))
        assert two.client.journal.changes == before


def test_a_journal_repeats_its_calls_in_order():
    """Arguments are those of the first time; a closed journal still calls but does not record."""
    seen: list[tuple[int, int]] = []

    def note(a: int, *, b: int) -> None:
        seen.append((a, b))

    journal = Journal()
    journal.call(note, 1, b=2)
    journal.call(note, 3, b=4)
    journal.close()
    journal.call(note, 5, b=6)
    journal.repeat()
    assert seen == [(1, 2), (3, 4), (5, 6), (1, 2), (3, 4)]


C = ctypes.CDLL(None)
LINES = 200
THREADS = f"""
import os, sys, threading
from rlbench_pin.environment.presets import low_dim_config, make_environment

def build(number):
    for _ in range(2):
        with make_environment(low_dim_config()) as environment:
            environment.get_task("reach_target").reset(seed=number)

before = [(os.fstat(fd).st_ino, os.fstat(fd).st_dev) for fd in (1, 2)]
threads = [threading.Thread(target=build, args=(i,)) for i in range(4)]
for thread in threads: thread.start()
for i in range({LINES}):
    os.write(1, b"line %d\\n" % i); print("text", i, flush=True); print("error", i, file=sys.stderr, flush=True)
    threads[0].join(0.01)
for thread in threads: thread.join()
assert before == [(os.fstat(fd).st_ino, os.fstat(fd).st_dev) for fd in (1, 2)]
print("end"); print("end", file=sys.stderr)
"""


def identity(descriptor: int) -> tuple[int, int]:
    """Return what says which file a descriptor stands for."""
    status = os.fstat(descriptor)
    return status.st_dev, status.st_ino


def test_what_c_prints_is_caught_and_what_python_prints_is_not(capfd: pytest.CaptureFixture[str]) -> None:
    """Nested, too; the descriptors are never anything else."""
    before = identity(1), identity(2)
    with captured_output() as outer:
        C.puts(b"one")
        print("python", flush=True)  # noqa: T201
        with captured_output() as inner:
            C.puts(b"two")
            assert (identity(1), identity(2)) == before
    with captured_output() as later:
        pass
    assert (outer.text, inner.text, later.text) == ("one\ntwo\n", "two\n", "")
    assert capfd.readouterr() == ("python\n", "")


def test_an_error_puts_everything_back() -> None:
    """And gives the text up to there."""
    with pytest.raises(ValueError), captured_output() as captured:
        C.puts(b"before")
        raise ValueError
    assert captured.text == "before\n"
    with captured_output() as again:
        C.puts(b"after")
    assert again.text == "after\n"


def test_threads_catch_one_after_the_other() -> None:
    """Each gets its own lines and no others."""
    texts: dict[int, str] = {}

    def catch(number: int) -> None:
        for _ in range(100):
            with captured_output() as captured:
                C.puts(b"thread %d" % number)
                C.puts(b"thread %d" % number)
            texts[number] = texts.get(number, "") + captured.text

    threads = [threading.Thread(target=catch, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert texts == {number: f"thread {number}\n" * 200 for number in range(4)}


@pytest.mark.simulation
def test_environments_built_in_threads_leave_the_output_alone(tmp_path: Path) -> None:
    """Every line that the process writes while four threads build environments arrives, on both descriptors."""
    out, err = tmp_path / "out.txt", tmp_path / "err.txt"
    with open(out, "wb") as stdout, open(err, "wb") as stderr:
        done = subprocess.run([sys.executable, "-c", THREADS], stdout=stdout, stderr=stderr, timeout=300, check=False)
    assert done.returncode == 0, err.read_text()
    lines = out.read_text().splitlines()
    assert lines == [text for i in range(LINES) for text in (f"line {i}", f"text {i}")] + ["end"]
    assert err.read_text().splitlines() == [f"error {i}" for i in range(LINES)] + ["end"]
