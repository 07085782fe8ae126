"""Pictures of cameras that programs name or made."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rlbench_pin.compat.things import CameraSettings, Element, ObjectTable
from rlbench_pin.compat.things.cameras import COLOR_CODED, CameraThing
from rlbench_pin.environment.observations.observe import normalised_depth, spread_mask
from rlbench_pin.sim import CameraView
from rlbench_pin.spatial import IDENTITY


def settings(table: ObjectTable, element: Element) -> CameraSettings:
    """Return what a camera is set to."""
    thing = table.thing(element)
    if isinstance(thing, CameraThing):
        return thing.camera
    camera = table.placed[element.name].camera
    assert camera is not None, "vision sensors carry settings"
    return camera


def set_settings(table: ObjectTable, element: Element, camera: CameraSettings) -> None:
    """Set a camera otherwise.

    Raises:
        CameraError: No picture can be taken like that.
    """
    check(camera)
    thing = table.thing(element)
    if isinstance(thing, CameraThing):
        thing.set_camera(camera)
    else:
        table.placed[element.name] = replace(table.placed[element.name], camera=camera)


def check(camera: CameraSettings) -> None:
    """Raise CameraError when no picture can be taken."""
    CameraView(IDENTITY.copy(), math.radians(camera.angle), camera.size, camera.near, camera.far)


def view(table: ObjectTable, element: Element) -> CameraView:
    """Return what a camera sees now."""
    thing = table.thing(element)
    if isinstance(thing, CameraThing):
        return table.cameras.view(thing.name)
    camera = settings(table, element)
    return CameraView(thing.pose, math.radians(camera.angle), camera.size, camera.near, camera.far)


def rgb(table: ObjectTable, element: Element) -> np.ndarray:
    """Take a picture, float32 (h, w, 3) in 0..1."""
    mode = settings(table, element).render_mode
    if mode == COLOR_CODED:
        mask = table.world.render(view(table, element), rgb=False, depth=False).mask
        assert mask is not None
        return spread_mask(mask)
    table.world.renderer.lighting = table.runtime.observer.appearance.lighting or table.cameras.config.lighting
    picture = table.world.render(view(table, element), depth=False, mask=False, shadows=mode.startswith("OPENGL3")).rgb
    assert picture is not None
    return picture.astype(np.float32) / np.float32(255.0)


def depth(table: ObjectTable, element: Element, in_meters: bool) -> np.ndarray:
    """Measure depth, float32 (h, w), in 0..1 from near to far plane or in [m]."""
    seen = view(table, element)
    metres = table.world.render(seen, rgb=False, mask=False).depth
    assert metres is not None
    return metres if in_meters else normalised_depth(metres, seen)


def point_cloud(metres: np.ndarray, extrinsics: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Return world coordinates (h, w, 3) [m] of every pixel of a depth picture (h, w) [m]."""
    height, width = metres.shape
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    pixels = np.stack([columns, rows, np.ones_like(columns)], axis=-1) @ np.linalg.inv(intrinsics).T
    points: np.ndarray = (pixels * metres[..., None]) @ np.asarray(extrinsics)[:3, :3].T + np.asarray(extrinsics)[:3, 3]
    return points


def switch_off(table: ObjectTable, element: Element) -> bool:
    """Let observations leave a camera out; False for what is the twin of one."""
    thing = table.thing(element)
    if not isinstance(thing, CameraThing) or thing.is_mask:
        return False
    table.cameras.settings_of(thing.name).set_all(False)
    return True
