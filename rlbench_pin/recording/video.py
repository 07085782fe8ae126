"""Videos of episodes: cameras that show the whole task or circle around it, grids of videos, and a recorder."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rlbench_pin.datasets import VideoWriter
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.robot.geometry import box_corners
from rlbench_pin.sim import CameraView, World, field_of_view, framed, look_at
from rlbench_pin.spatial import FloatArray, above_table
from rlbench_pin.values import as_path, as_record

VIDEO_SIZE = (640, 480)
"""Width and height [px]."""
EYE = (-0.05, 1.62, 1.80)
"""Position of the camera of videos: to the left of the robot [m]."""
NEAR, FAR = 0.05, 6.0
_ARM = np.array([(x, y, above_table(z)) for x in (-0.45, 0.15) for y in (-0.2, 0.2) for z in (0.0, 1.0)])
"""Corners of a box around the usual positions of the arm [m]."""
_GAP, _TEXT, _PADDING = 4, 14, 6
"""Sizes in a grid of videos: gap between cells, height of captions, margin of captions [px]."""


def points_to_show(world: World) -> FloatArray:
    """Return points (n, 3) around the arm and all objects of the task [m]."""
    boxes = [box_corners(body.bounds(), body.pose) for body in world.bodies.values()]
    return np.concatenate([_ARM, world.robot.tip_pose()[None, :3], *boxes])


@dataclass(frozen=True)
class Orbit:
    """Circular path of a camera above the table, inside the room."""

    size: tuple[int, int] = (1280, 720)
    """Width and height [px]."""
    step: float = 0.005
    """Angle between two images [rad]."""
    start: float = 1.0
    """First angle, 0 in front of the robot and positive to its left [rad]."""
    center: tuple[float, float, float] = (0.12, 0.0, 1.22)
    """Target of the camera [m]."""
    radius: float = 1.6
    """Distance from the centre, seen from above [m]."""
    height: float = 1.75
    """Height above the floor [m]."""
    fov: float = 1.15
    """Field of view of the longer side [rad]."""

    def view(self, frame: int) -> CameraView:
        """Return the camera of image number `frame`."""
        angle = self.start + frame * self.step
        x, y, _ = self.center
        eye = (x + self.radius * float(np.cos(angle)), y + self.radius * float(np.sin(angle)), self.height)
        return CameraView(pose=look_at(eye, self.center), fov=self.fov, size=self.size, near=NEAR, far=FAR)

    def around(self, world: World) -> Orbit:
        """Return the orbit whose image contains the arm and the whole task of a world, for the first 1.5 rad."""
        points = points_to_show(world)
        low, high = points.min(axis=0), points.max(axis=0)
        x, y, z = ((low + high) / 2.0).tolist()
        orbit = replace(self, center=(x, y, z))
        turned = (replace(orbit, start=self.start + angle) for angle in np.linspace(0.0, 1.5, 7).tolist())
        return replace(orbit, fov=max(field_of_view(each.view(0), points) for each in turned))

    def image(self, world: World, frame: int) -> np.ndarray:
        """Return image number `frame` of the world in its current state, uint8 (h, w, 3)."""
        return world.renderer.image(self.view(frame))


class Clip:
    """Images of one video, compressed in memory."""

    def __init__(self) -> None:
        self._frames: list[bytes] = []

    def __len__(self) -> int:
        return len(self._frames)

    def add(self, image: np.ndarray) -> None:
        """Append an image, uint8 (h, w, 3)."""
        stream = io.BytesIO()
        Image.fromarray(image).save(stream, "JPEG", quality=92)
        self._frames.append(stream.getvalue())

    def frame(self, number: int) -> Image.Image:
        """Return an image; a number after the end gives the last one."""
        return Image.open(io.BytesIO(self._frames[min(number, len(self) - 1)]))


def grid_shape(count: int) -> tuple[int, int]:
    """Return columns and rows for `count` cells, as nearly equal as possible."""
    columns = int(np.ceil(np.sqrt(count)))
    return columns, -(-count // columns)


def grid_size(count: int, cell: tuple[int, int]) -> tuple[int, int]:
    """Return width and height of a grid of cells [px], both even."""
    columns, rows = grid_shape(count)
    width, height = columns * (cell[0] + _GAP) - _GAP, rows * (cell[1] + _GAP) - _GAP
    return width + width % 2, height + height % 2


def grid_frames(clips: Mapping[str, Clip], cell: tuple[int, int]) -> Iterator[np.ndarray]:
    """Yield the images of all videos side by side, with captions, until the longest has ended."""
    columns, _ = grid_shape(len(clips))
    fonts = {name: _font(name, cell[0] - 2 * _PADDING) for name in clips}
    for number in range(max(len(clip) for clip in clips.values())):
        sheet = Image.new("RGB", grid_size(len(clips), cell), (20, 20, 20))
        draw = ImageDraw.Draw(sheet)
        for i, (name, clip) in enumerate(clips.items()):
            corner = (i % columns) * (cell[0] + _GAP), (i // columns) * (cell[1] + _GAP)
            sheet.paste(clip.frame(number), corner)
            place = corner[0] + _PADDING, corner[1] + 4
            draw.text(place, _caption(name), fill=(30, 30, 30), font=fonts[name], stroke_width=1, stroke_fill=(245, 245, 245))
        yield np.asarray(sheet)


def _caption(name: str) -> str:
    return name.replace("_", " ")


def _font(name: str, width: float) -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    """Return the largest font in which the caption is at most `width` [px] wide; 7 at least."""
    sizes = (ImageFont.load_default(size) for size in range(_TEXT, 7, -1))
    return next((font for font in sizes if font.getlength(_caption(name)) <= width), ImageFont.load_default(7))


def side_view(world: World) -> CameraView:
    """Return a camera to the left of the robot whose image contains the arm and the whole task in their current poses."""
    return framed(EYE, points_to_show(world), VIDEO_SIZE)


class VideoRecorder:
    """Records a video of every tick in a `with` block; `keep` moves it to a path, otherwise it is deleted.

    Args:
        task: The environment to record.
        folder: Folder to write to while recording.
    """

    def __init__(self, task: TaskEnvironment, folder: Path) -> None:
        self._task = as_record(task, TaskEnvironment, "task")
        fps = round(1.0 / task.world.control_dt)
        self._video = VideoWriter(as_path(folder, "folder") / f".recording{os.getpid()}.mp4", VIDEO_SIZE, fps)
        self._pause = fps
        self._kept = False
        self._view: CameraView | None = None

    def __enter__(self) -> VideoRecorder:
        self._task.runtime.register_step_callback(self._add_tick)
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self._task.runtime.remove_step_callback(self._add_tick)
        if not self._kept:
            self._video.discard()

    def keep(self, path: Path) -> Path:
        """Append the last image for 1 s, finish the video, move it to `path`, and return `path`."""
        last = self._image()
        for _ in range(self._pause):
            self._video.add(last)
        self._kept = True
        path.parent.mkdir(parents=True, exist_ok=True)
        os.replace(self._video.close(), path)
        return path

    def _add_tick(self) -> None:
        self._video.add(self._image())

    def _image(self) -> np.ndarray:
        if self._view is None:
            self._view = side_view(self._task.world)
        return self._task.world.renderer.image(self._view)
