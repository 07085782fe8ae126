"""`rlbench-pin doctor`: check the renderers, videos and libraries of this machine."""

from __future__ import annotations

import json
import platform
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from rlbench_pin.errors import CameraError, RlbenchPinError

_DARK, _FLAT = 8.0, 4.0


@dataclass(frozen=True)
class Doctor:
    """Check this machine: one PyBullet, an image with each renderer, a video; print the versions of the libraries."""

    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Run all checks; return 1 when a required one fails."""
        from rlbench_pin.environment.demos import library_versions

        findings = [
            _tried("one pybullet", True, check_pybullet),
            _tried("renderer cpu", True, lambda: check_renderer("cpu")),
            _tried("renderer egl", False, lambda: check_renderer("egl")),
            _tried("videos", True, check_videos),
        ]
        versions = {"python": platform.python_version(), **library_versions()}
        if self.json:
            print(json.dumps({"findings": [asdict(finding) for finding in findings], "versions": versions}, indent=1))
        else:
            for finding in findings:
                print(finding.line())
            print("versions " + ", ".join(f"{name} {version}" for name, version in versions.items()))
        return int(any(finding.needed and not finding.works for finding in findings))


@dataclass(frozen=True)
class Finding:
    """One check."""

    what: str
    works: bool
    needed: bool
    detail: str

    def line(self) -> str:
        """The check as a line of text."""
        mark = "ok     " if self.works else ("BROKEN " if self.needed else "missing")
        return f"{mark} {self.what:<16} {self.detail}"


def _tried(what: str, needed: bool, attempt: Callable[[], str]) -> Finding:
    try:
        return Finding(what, True, needed, attempt())
    except (RlbenchPinError, OSError) as error:
        return Finding(what, False, needed, str(error))


def check_pybullet() -> str:
    """Return the installed distribution of the module `pybullet`.

    Raises:
        RlbenchPinError: Both distributions are installed. They overwrite each other's files.
    """
    from rlbench_pin.environment.demos import pybullet_distributions

    found = pybullet_distributions()
    if len(found) > 1:
        raise RlbenchPinError(
            f"Two distributions install the module `pybullet`: {' and '.join(found)}. They overwrite each other's files. "
            "Run `pip uninstall --yes pybullet pybullet-arm64`, then install rlbench-pin again, which installs the right one."
        )
    return ", ".join(found) or "installed without metadata"


def check_renderer(renderer: Literal["cpu", "egl"]) -> str:
    """Take an image of the empty table and return how long it took.

    Raises:
        CameraError: The renderer is not available on this machine, or its images are black or uniform.
    """
    from rlbench_pin.environment.observations.config import CameraConfig
    from rlbench_pin.environment.observations.observe import camera_view
    from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
    from rlbench_pin.scene.spec import SceneSpec
    from rlbench_pin.sim import World

    robot = robot_description(DEFAULT_ROBOT)
    with World(SceneSpec(format=1), robot, renderer=renderer) as world:
        world.robot.reset_configuration(np.array(robot.home))
        view = camera_view("front", CameraConfig(), world, robot)
        images = world.render(view, shadows=True)
        assert images.rgb is not None and images.mask is not None
        arm = [number for number, name in world.masks.items() if name.startswith(robot.name)]
        check_image(images.rgb, np.isin(images.mask, arm), renderer)
        began = time.perf_counter()
        for _ in range(5):
            world.render(view)
        took = (time.perf_counter() - began) / 5.0
    return f"{1e3 * took:.1f} ms for 128 x 128 px with depth and mask"


def check_image(rgb: np.ndarray, arm: np.ndarray, renderer: str) -> None:
    """Check an image (h, w, 3) in which `arm` (h, w) marks the robot.

    Raises:
        CameraError: It is black or uniform, or the robot in it is missing or black.
    """
    if rgb.mean() < _DARK or rgb.std() < _FLAT:
        raise CameraError(f"Renderer '{renderer}' returns black or uniform images (mean {rgb.mean():.0f}). Use another renderer.")
    if not arm.any() or rgb[arm].mean() < _DARK:
        raise CameraError(f"Renderer '{renderer}' draws no robot, or a black robot. Use another one, or update the driver.")


def check_videos() -> str:
    """Write a short video and return how large it is."""
    from rlbench_pin.datasets import VideoWriter

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "video.mp4"
        with VideoWriter(path, (64, 48)) as video:
            for brightness in range(0, 200, 20):
                video.add(np.full((48, 64, 3), brightness, dtype=np.uint8))
        return f"an MP4 of ten images has {path.stat().st_size} bytes"
