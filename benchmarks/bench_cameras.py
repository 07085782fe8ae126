"""Images: ms per camera and per observation, beside a naive PyBullet camera on the meshes as shipped, in the same run.

Goals: RGB, depth and mask at 128 px within 3 ms per camera without shadows and at least ten times faster than the naive camera;
observations of five cameras, with the step, at least 25 per second with default appearance and 60 without shadows.
Times are of the process (CPU), so that other programs do not change them; the notes give the clock on the wall too.
"""

from __future__ import annotations

import tempfile
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pybullet
from harness import Result, main, summary

from rlbench_pin.environment import CameraConfig, Discrete, Environment, JointVelocity, MoveArmThenGripper, ObservationConfig
from rlbench_pin.environment.observations.observe import camera_view
from rlbench_pin.errors import CameraError
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot.description import robot_description
from rlbench_pin.sim import CameraView, Request, World
from rlbench_pin.tasks import task_class, task_scene

SIZES = (64, 128, 256, 512)
PRODUCTS = {
    "rgb": {"rgb": True, "depth": False, "mask": False},
    "rgb-depth": {"rgb": True, "depth": True, "mask": False},
    "rgb-depth-mask": {"rgb": True, "depth": True, "mask": True},
}
TASK = "stack_blocks"


def timed(operation: Callable[[], object], repeats: int) -> tuple[list[float], float]:
    """CPU seconds of each call, and the median on the wall."""
    operation(), operation()
    cpu, wall = [], []
    for _ in range(repeats):
        began, clock = time.process_time(), time.perf_counter()
        operation()
        cpu.append(time.process_time() - began)
        wall.append(time.perf_counter() - clock)
    return cpu, float(np.median(wall))


def result(name: str, operation: Callable[[], object], repeats: int, note: str = "") -> Result:
    """Measure one operation."""
    cpu, wall = timed(operation, repeats)
    return summary(name, cpu, f"{1e3 * wall:.1f} ms on the wall{note}", wall=wall)


# The naive camera ----------------------------------------------------------------------------------------------------


def shipped_panda(folder: Path) -> Path:
    """Write a URDF of the Panda with the meshes of example-robot-data, and return it."""
    import pinocchio

    site = Path(pinocchio.__file__).resolve()
    share = next(p / "share" / "example-robot-data" for p in site.parents if (p / "share" / "example-robot-data").is_dir())
    robot = share / "robots" / "panda_description"
    tree = ET.parse(next((robot / "urdf").glob("panda.urdf")))
    for mesh in tree.iter("mesh"):
        name = mesh.get("filename", "").split("panda_description/")[-1]
        mesh.set("filename", str(robot / name))
    path = folder / "panda.urdf"
    tree.write(path)
    return path


class NaiveCamera:
    """Baseline of a simple PyBullet script: load the shipped robot, a table, blocks, and call getCameraImage with defaults."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._client = pybullet.connect(pybullet.DIRECT)
        where = {"physicsClientId": self._client}
        description = robot_description("panda")
        pybullet.setAdditionalSearchPath(str(_pybullet_data()), **where)
        pybullet.loadURDF("plane.urdf", **where)
        pybullet.loadURDF("table/table.urdf", [0.3, 0.0, 0.12], **where)
        urdf = shipped_panda(Path(self._folder.name))
        robot = pybullet.loadURDF(str(urdf), description.base_pose[:3], useFixedBase=True, **where)
        for joint, value in enumerate(description.home):
            pybullet.resetJointState(robot, joint, value, **where)
        for i in range(8):
            place = [0.1 + 0.06 * i, 0.1 * (i % 3), 0.78]
            pybullet.loadURDF("cube_small.urdf", place, **where)

    def shoot(self, view: CameraView) -> object:
        """Take an image and make arrays of it."""
        eye = view.pose[:3].tolist()
        target = (view.extrinsics() @ [0.0, 0.0, 1.0, 1.0])[:3].tolist()
        width, height = view.size
        look = pybullet.computeViewMatrix(eye, target, [0.0, 0.0, 1.0])
        lens = pybullet.computeProjectionMatrixFOV(np.degrees(view.fov), width / height, view.near, view.far)
        _, _, rgb, depth, mask = pybullet.getCameraImage(
            width, height, look, lens, renderer=pybullet.ER_TINY_RENDERER, physicsClientId=self._client
        )
        return np.reshape(rgb, (height, width, 4))[..., :3], np.array(depth), np.array(mask)

    def close(self) -> None:
        """Free the server."""
        pybullet.disconnect(self._client)
        self._folder.cleanup()


def _pybullet_data() -> Path:
    import pybullet_data

    return Path(pybullet_data.getDataPath())


# Ours ----------------------------------------------------------------------------------------------------------------


def worlds() -> dict[str, World]:
    """One world per renderer that works here."""
    scene, robot = task_scene(task_class(TASK)), robot_description("panda")
    found = {"cpu": World(scene, robot)}
    try:
        found["egl"] = World(scene, robot, renderer="egl")
    except CameraError as error:
        print(f"no EGL here: {error}")
    for world in found.values():
        world.robot.reset_configuration(np.array(robot.home))
    return found


def all_cameras(world: World, size: int, products: dict[str, bool], shadows: bool) -> Callable[[], object]:
    """Take the images of all five cameras, as an observation does."""
    robot = robot_description("panda")

    def shoot() -> None:
        # A moving camera is drawn anew each time: the gripper turns a little.
        world.robot.reset_configuration(np.array(robot.home) + np.array([0, 0, 0, 0, 0, 0, next(turns)]))
        views = [camera_view(name, CameraConfig(image_size=(size, size)), world, robot) for name in CAMERAS]
        world.renderer.render_all([Request(view, **products, shadows=shadows) for view in views])

    turns = iter(np.linspace(0.0, 0.5, 1000))
    return shoot


def naive_cameras(world: World) -> dict[str, Result]:
    """The five views at 128 px, taken naively."""
    naive, robot = NaiveCamera(), robot_description("panda")
    views = {name: camera_view(name, CameraConfig(), world, robot) for name in CAMERAS}
    results = {name: result(f"naive {name} 128 px", lambda view=view: naive.shoot(view), 8) for name, view in views.items()}
    naive.close()
    return results


def per_camera(world: World, renderer: str, naive: dict[str, Result]) -> list[Result]:
    """Each camera alone at 128 px, beside the naive one."""
    robot = robot_description("panda")
    results = []
    for name in CAMERAS:
        view = camera_view(name, CameraConfig(), world, robot)
        measured = result(f"{renderer} {name} 128 px rgb-depth-mask", lambda view=view: world.render(view), 40)
        ratio = naive[name].median / measured.median
        results.append(summary_with(measured, f"{ratio:.0f} x faster than naive", ratio=ratio))
    mean, slow = (float(np.mean([r.median for r in rs])) for rs in (results, naive.values()))
    note = f"mean of the five; {slow / mean:.1f} x faster than naive ({1e3 * slow:.1f} ms)"
    return [*results, summary(f"{renderer} mean camera 128 px rgb-depth-mask", [mean], note, ratio=slow / mean)]


def summary_with(measured: Result, note: str, **extra: float) -> Result:
    """The same result with a longer note."""
    return replace(measured, note=f"{measured.note}; {note}", extra={**measured.extra, **extra})


def observations(shadows: bool, pixels: int = 128) -> Result:
    """Steps with five cameras, all products."""
    config = ObservationConfig()
    for camera in config.cameras().values():
        camera.render_mode, camera.image_size = ("opengl3" if shadows else "opengl"), (pixels, pixels)
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, seed=0) as environment:
        task = environment.get_task("reach_target")
        task.reset(seed=0)
        action = np.array([0.1, 0.1, -0.1, 0.1, 0.1, -0.1, 0.1, 1.0])
        cpu, wall = timed(lambda: task.step(action), 40)
    rate = 1.0 / float(np.median(cpu))
    looks = "default appearance" if shadows else "no shadows"
    note = f"{rate:.0f} observations/s, {1.0 / wall:.0f} on the wall"
    return summary(f"step and five cameras {pixels} px, {looks}", cpu, note, per_second=rate, wall=wall)


def benchmark(sizes: tuple[int, ...] = SIZES) -> list[Result]:
    """Measure everything."""
    found = worlds()
    naive = naive_cameras(found["cpu"])
    results = [*naive.values()]
    for renderer, world in found.items():
        results += per_camera(world, renderer, naive)
        for size in sizes:
            for name, products in PRODUCTS.items():
                for shadows in (False, True):
                    looks = " shadows" if shadows else ""
                    repeats = max(4, 2560 // size // (4 if renderer == "egl" else 1))
                    operation = all_cameras(world, size, products, shadows)
                    results.append(result(f"{renderer} five cameras {size} px {name}{looks}", operation, repeats))
    for world in found.values():
        world.close()
    return [*results, observations(True), observations(False)]


if __name__ == "__main__":
    main(__doc__, benchmark)
