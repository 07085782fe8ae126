"""Draw the images of docs/concepts.md: one for each concept, 640 px wide.

Usage: python scripts/concept_images.py [--out FOLDER]    docs/images/concepts
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    Listener,
    MoveArmThenGripper,
    TaskEnvironment,
    low_dim_config,
    make_environment,
)
from rlbench_pin.sim import CameraView, Images, look_at
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.tasks.waypoints import waypoints_of

OUT = Path(__file__).resolve().parents[1] / "docs" / "images" / "concepts"
WIDTH, GAP, QUALITY = 640, 4, 85
EYE, TARGET, FOV = (1.25, 0.75, 1.35), (0.2, 0.0, 0.9), 0.62
"""Camera of all images but those of the gripper: ahead of the robot, on its left [m, rad]."""
DOT, LINE = (255, 120, 0), (255, 200, 0)
AXES = ((220, 40, 40), (40, 160, 40), (40, 80, 230))
"""Colours of x, y and z."""


def view(size: tuple[int, int], eye: Sequence[float] = EYE, target: Sequence[float] = TARGET, fov: float = FOV) -> CameraView:
    """Return a camera at `eye` that looks at `target`."""
    return CameraView(pose=look_at(eye, target), fov=fov, size=size, near=0.05, far=5.0)


def photo(task: TaskEnvironment, camera: CameraView) -> Image.Image:
    """Render the present state."""
    images: Images = task.world.render(camera, depth=False, mask=False, shadows=True, antialiasing=True)
    return Image.fromarray(images.rgb)


def pixels(camera: CameraView, points: FloatArray) -> list[tuple[float, float]]:
    """Return where points (n, 3) [m] are in the image."""
    scaled = np.column_stack([points, np.ones(len(points))]) @ camera.to_image.T
    return [(float(u / z), float(v / z)) for u, v, z in scaled]


def label(image: Image.Image, text: str) -> Image.Image:
    """Write a text into the upper left corner."""
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    draw.rectangle((0, 0, draw.textlength(text, font) + 12, 24), fill=(255, 255, 255))
    draw.text((6, 3), text, fill=(0, 0, 0), font=font)
    return image


def row(images: Sequence[Image.Image]) -> Image.Image:
    """Set images of one size beside each other."""
    width, height = images[0].size
    strip = Image.new("RGB", (WIDTH, height), (255, 255, 255))
    for k, image in enumerate(images):
        strip.paste(image, (k * (width + GAP), 0))
    return strip


def cell(columns: int, height: int) -> tuple[int, int]:
    """Return the size of one of several images beside each other [px]."""
    return (WIDTH - (columns - 1) * GAP) // columns, height


def frames(task: TaskEnvironment, seed: int, camera: CameraView, wanted: Callable[[int], Sequence[int]]) -> list[Image.Image]:
    """Play a demonstration and return the images of some of its frames, which `wanted` chooses by their count."""
    demo = task.get_demos(1, live_demos=True, seed=seed)[0]
    chosen, found, count = set(wanted(len(demo))), [], 0

    def look(_: object) -> None:
        nonlocal count
        if count in chosen:
            found.append(photo(task, camera))
        count += 1

    task.try_demo(seed=seed, attempt=demo.attempt, on_frame=look)
    return found


def episode() -> Image.Image:
    """Four moments of an episode of `pick_and_lift`."""
    camera = view(cell(4, 220), target=(0.15, 0.0, 1.05), fov=0.72)
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        found = frames(task, 0, camera, lambda count: [0, int(0.45 * count), int(0.75 * count), count - 1])
    return row([label(image, text) for image, text in zip(found, ("reset", "step", "step", "reward 1"))])


def waypoint() -> Image.Image:
    """The waypoints of `pick_and_lift` as frames, in their order."""
    camera = view((WIDTH, 380), eye=(0.95, 0.7, 1.25), target=(0.22, 0.02, 0.93), fov=0.72)
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        task.reset(seed=0)
        image = photo(task, camera)
        poses = [pose_to_matrix(w.pose) for w in waypoints_of(task.world)]
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(18)
    draw.line(pixels(camera, np.array([T[:3, 3] for T in poses])), fill=LINE, width=2)
    for k, T_world_tip in enumerate(poses):
        origin = T_world_tip[:3, 3]
        ends = [origin + 0.05 * T_world_tip[:3, axis] for axis in range(3)]
        start, *tips = pixels(camera, np.array([origin, *ends]))
        for tip, color in zip(tips, AXES):
            draw.line((start, tip), fill=color, width=3)
        text = ", ".join(str(i) for i, other in enumerate(poses) if np.allclose(other, T_world_tip, atol=1e-3))
        if text.startswith(str(k)):  # the first of those with one pose
            place = (start[0] - 16 - draw.textlength(text, font), start[1] - 10)
            draw.text(place, text, fill=(0, 0, 0), font=font, stroke_width=2, stroke_fill=(255, 255, 255))
    return image


class Tips(Listener):
    """Tip positions [m] after each control tick."""

    def __init__(self, task: TaskEnvironment) -> None:
        self.task, self.positions = task, [task.world.robot.tip_pose()[:3]]

    def on_tick(self, seconds: float) -> None:
        self.positions.append(self.task.world.robot.tip_pose()[:3])


def action_mode() -> Image.Image:
    """One action by planning and ten actions by tip velocity; a dot for each control tick."""
    camera = view(cell(2, 300), eye=(1.35, 1.05, 1.6), target=(0.13, 0.0, 1.12), fov=0.68)
    modes = {"one planned pose": EndEffectorPoseViaPlanning(), "ten tip velocities": EndEffectorVelocity()}
    found = []
    for text, arm in modes.items():
        with Environment(MoveArmThenGripper(arm, Discrete()), obs_config=low_dim_config()) as environment:
            task = environment.get_task("reach_target")
            _, observation = task.reset(seed=2)
            tips, target = Tips(task), task.world.body("target").position
            if isinstance(arm, EndEffectorVelocity):
                actions = [np.array([*(0.6 * (target - observation.gripper_pose[:3])), 0.0, 0.0, 0.0, 1.0])] * 10
            else:
                actions = [np.array([*target, 0.0, 1.0, 0.0, 0.0, 1.0])]
            with task.runtime.listening(tips):
                for action in actions:
                    task.step(action)
            image = photo(task, camera)
        draw = ImageDraw.Draw(image)
        for u, v in pixels(camera, np.array(tips.positions)):
            draw.ellipse((u - 3, v - 3, u + 3, v + 3), fill=DOT)
        found.append(label(image, f"{text}: {len(tips.positions) - 1} ticks"))
    return row(found)


def seed() -> Image.Image:
    """Starts of `stack_blocks` with three seeds, the third again the first."""
    camera, found = view(cell(3, 190), eye=(0.95, 0.0, 1.5), target=(0.27, 0.04, 0.77), fov=0.7), []
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("stack_blocks")
        for number in (0, 1, 0):
            task.reset(seed=number, variation=0)
            found.append(label(photo(task, camera), f"seed {number}"))
    return row(found)


def attachment() -> Image.Image:
    """The gripper of `pick_and_lift` around the block, closed on it, and lifted."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        demo = task.get_demos(1, live_demos=True, seed=0)[0]
        opening = np.array([observation.gripper_open for observation in demo])
        closed = int(np.flatnonzero(opening < 0.5)[0])
        near = demo[closed].gripper_pose[:3]
        camera = view(cell(3, 220), eye=near + [0.42, 0.32, 0.14], target=near + [0.0, 0.0, 0.05], fov=0.55)
        found = frames(task, 0, camera, lambda _: [closed - 4, closed, closed + 12])
    return row([label(image, text) for image, text in zip(found, ("open", "closed: attached", "moves with the gripper"))])


def success() -> Image.Image:
    """The drawer of `open_drawer` shut, not far enough out, and open by 15 cm."""
    camera, found, joint = view(cell(3, 220), eye=(0.3, 1.35, 1.5), target=(0.29, 0.08, 0.95), fov=0.8), [], "chest/drawer_bottom"
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("open_drawer")
        demo = task.get_demos(1, live_demos=True, seed=0)[0]
        last = 0.0

        def look(_: object) -> None:
            nonlocal last
            drawn = task.world.joint(joint).position
            if not found or last < 0.08 <= drawn or last < 0.15 <= drawn:
                reward = float(task.task.success()[0])
                found.append(label(photo(task, camera), f"{100 * drawn:.0f} cm out: reward {reward:.0f}"))
            last = drawn

        task.try_demo(seed=0, attempt=demo.attempt, on_frame=look)
    return row(found[:3])


DRAWN = (episode, waypoint, action_mode, seed, attachment, success)


def main() -> None:
    """Write all images."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=OUT)
    folder = parser.parse_args().out
    folder.mkdir(parents=True, exist_ok=True)
    for draw in DRAWN:
        path = folder / f"{draw.__name__}.jpg"
        draw().save(path, quality=QUALITY, optimize=True)
        print(f"{path}: {path.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
