"""Contact sheets of demonstrations: each event from a camera aimed at the task, and from the observation cameras."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy import ndimage

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.presets import clear_view, low_dim_config, make_environment
from rlbench_pin.errors import DemoError
from rlbench_pin.observation import CAMERAS, Demo, Observation
from rlbench_pin.robot.description import DEFAULT_ROBOT
from rlbench_pin.robot.geometry import bounds, box_corners, visual_geometry
from rlbench_pin.sim import Body, CameraView, Images, Request, ShadowMap, World, WorldState, framed
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.tasks import Task

SIZE = 384
"""Side of the task view [px]."""
OVERVIEW = "clear_robot_side"
"""Camera that shows arm and table, in addition to the five observation cameras."""
_FINER = 3
"""Factor by which images are rendered larger than they are shown."""
_AFTER = 1.0
"""Time after success at which the last image is taken [s]."""
_RELEASED, _FALLEN = 0.5, 0.03
"""Time for which the gripper opens [s], and minimum motion in this time of a held body that falls [m]."""
_HIDDEN = ", arm hidden on the left"
_HAND, _THROUGH, _COVERED, _BLUR = 0.95, 0.3, 0.22, 2.0
"""Where only the gripper is drawn: opacity of its hand in general, opacity in front of small relevant links of the task, maximum
length of such links [m], and blur of the border between both [px]. Fingers are opaque."""
_OUTLINE = 0.55
"""Opacity of the dark line around the hand."""
_SHADOW = 0.4
"""Strength of the shadow of the arm where only the gripper is drawn."""
_LARGE = 0.35
"""Minimum longest side of a large body, of which the image contains only a part [m]."""
_NEAR = 0.16
"""Maximum distance from moving links of the parts of large bodies that the image contains [m]."""
_WHOLE, _TINY = 1.4, 0.1
"""The image contains whole large bodies if its content becomes at most this factor longer, and if the longest moving link has
at least this fraction of the length of the content."""
_AROUND = 0.04
"""Margin around the content of the image [m]."""
_BESIDE_TASK = 0.09
"""Maximum distance of the gripper from the other content at which the image contains the gripper [m]."""
_CLEAR_WAY = 0.05
"""Motions from the first to the last frame that are longer than this should be visible across the image [m]."""
_LEVER = 0.1
"""Lever arm that converts rotations to distances [m]."""
_SHORT, _LONG, _VERY_LONG = 10, 40, 350
"""Frames between contact and success without one half way, between contact and grasp from which on both are shown, and from which
on more are shown: one between contact and grasp, and one for each quarter of the way between grasp and success."""
_AT = 0.7
"""Time of the frame between contact and grasp, as a fraction of the time between them."""
_STILL, _MOVED = 5e-4, 3e-3
"""Maximum motion of a stationary link between two frames, and over a demonstration [m]."""
_DIRECTIONS = [(side * azimuth, tilt) for tilt in (25.0, 40.0, 55.0) for azimuth in range(15, 180, 30) for side in (1, -1)]
"""Possible directions from the task to the camera: azimuth from +x towards +y, and elevation [deg]."""
_NEAREST, _PER_RADIUS = 0.7, 3.4
"""Distance of the camera from the middle of the task: minimum [m], and multiple of the radius of the task."""
_INSIDE = np.array([(-1.4, -1.75, 0.9), (1.9, 1.75, 2.5)])
"""Corners of the box of possible camera positions [m]."""
_SMALL = 96
"""Side of the masks for the choice of the direction [px]."""
_ENOUGH = 0.7
"""Fraction of the visible pixels of a link in the best view from which on more pixels do not improve a view."""
_WELL = 0.3
"""Fraction of the visible pixels of a link in the best view from which on a view shows the link well."""
_FINGERS, _END, _REVEALED, _APART = 1.4, 4.0, 3.0, 1.5
"""Weights in the score of a view: visible fingers, moved links at the end, links that a door or lid hides, and distance in the
image between removed bodies and the rest."""
_STEEP = 0.8
"""Decrease of the score for each step of elevation above the lowest."""
_FACING, _BEFORE, _CLEARLY = 6.0, (-0.1, 0.5), 0.6
"""Increase of the score of a view from the side of the moving bodies; range of cosines in which it grows; and minimum length of
the mean of unit vectors towards that side for the full increase."""
_ACROSS = 2.5
"""Weight of the visible fraction of the length of the motion."""
_BESIDE = 0.01
"""Maximum distance of bodies that touch, for images [m]."""
_MARGIN, _GAP, _CAPTION, _TITLE = 8, 8, 18, 54
_INK, _PAPER, _FAINT = (30, 30, 30), (255, 255, 255), (110, 110, 110)


@dataclass(frozen=True, eq=False)
class Moment:
    """An event of a demonstration in images."""

    label: str
    """Name of the event and its time."""
    view: CameraView
    """The camera that is aimed at the task."""
    arm_hidden: bool
    """Whether the arm is left out of its image."""
    task: Image.Image
    """Image of that camera. It shows at most the gripper of the arm, with an outline. The gripper is transparent in front of
    small links that move, and of the links that they touch at the end."""
    with_arm: Image.Image
    """The same image with the whole arm."""
    cameras: Mapping[str, Image.Image]
    """Images of the five observation cameras and of the overview camera, by name."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The world at one frame of a demonstration."""

    time: float
    """Simulated time [s]."""
    state: WorldState
    poses: Mapping[tuple[str, str], FloatArray]
    """Body and link -> pose (7,) in the world, of all links with visuals; a task may add and remove bodies."""
    holds: bool
    """Whether the gripper holds a body."""
    touches: bool
    """Whether the robot touches a body of the task."""
    tip: FloatArray
    """Position (3,) of the tip in the world [m]."""


# Sheets -----------------------------------------------------------------------------------------------------------


def demo_sheet(
    task: type[Task],
    seed: int,
    variation: int = 0,
    *,
    attempt: int | None = None,
    size: int = SIZE,
    robot: str = DEFAULT_ROBOT,
) -> tuple[Image.Image, str]:
    """Draw a demonstration, and return the image and the name of the task.

    Args:
        task: Class of the task.
        seed: Seed of the episode.
        variation: Variation of the task.
        attempt: Number of the attempt of the seed; None takes the first that succeeds.
        size: Side of the task view [px]; the other images have about half of it.
        robot: Name of the arm.

    Raises:
        DemoError: The demonstration fails.
    """
    demo, moments = demo_moments(task, seed, variation, attempt=attempt, size=size, robot=robot)
    rows = [[np.asarray(moment_image(moment))] for moment in moments]
    title = f"{demo.task_name}: {demo.instructions[0]}"
    arm = "" if robot == DEFAULT_ROBOT else f"{robot}, "
    subtitle = f"{arm}variation {demo.variation_number}, seed {seed}, {len(demo)} frames; on the left a camera aimed at the task"
    return contact_sheet(rows, [moment.label for moment in moments], [""], title, subtitle), demo.task_name


def demo_moments(
    task: type[Task],
    seed: int,
    variation: int = 0,
    *,
    attempt: int | None = None,
    size: int = SIZE,
    robot: str = DEFAULT_ROBOT,
) -> tuple[Demo, list[Moment]]:
    """Play a demonstration, and return it with images of its events; see `demo_sheet`.

    Of the arm, task views show only the gripper; the first view shows no part of it. The last view is 1 s after success, with arm
    and gripper stationary. It shows the gripper only if the gripper holds a body, or if no link of the task has moved.
    """
    with make_environment(low_dim_config(), robot=robot) as environment:
        task_environment = environment.get_task(task)
        world = task_environment.world
        frames: list[Frame] = []
        demo = _demonstrate(task_environment, seed, variation, attempt, lambda _: frames.append(present_frame(world)))
        del frames[: -len(demo)]  # those of attempts that failed
        chosen = {
            f"{name}, {frames[k].time - frames[0].time:.1f} s" if k else f"{name}{_HIDDEN}": frames[k]
            for name, k in events(_common_poses(frames)[1], [f.holds for f in frames], [f.touches for f in frames]).items()
        }
        end = _wait(task_environment)
        held = end.holds or _lets_fall(task_environment, end)
        hides_arm = not held and any(_moves(frames[0], frame, _MOVED) for frame in (*chosen.values(), end))
        note = _HIDDEN if hides_arm else ", object still held" if held else ""
        chosen[f"{_AFTER:.0f} s after success{note}"] = end
        view = task_view(world, list(chosen.values()), size, hides_arm=hides_arm)
        through = _seen_through(world, list(chosen.values()))
        return demo, [
            _moment(task_environment, label, frame, view, None if label.endswith(_HIDDEN) else through)
            for label, frame in chosen.items()
        ]


def moment_image(moment: Moment) -> Image.Image:
    """Return the task view, with the other images to its right in two rows with captions."""
    size, small = moment.task.width, next(iter(moment.cameras.values())).width
    columns = -(-len(moment.cameras) // 2)
    row = Image.new("RGB", (size + columns * (_GAP + small), max(size, 2 * (_CAPTION + small) + _GAP)), _PAPER)
    row.paste(moment.task, (0, 0))
    draw = ImageDraw.Draw(row)
    for k, (name, image) in enumerate(moment.cameras.items()):
        x, y = size + _GAP + k % columns * (_GAP + small), k // columns * (_CAPTION + small + _GAP)
        draw.text((x, y), name.replace("_", " "), fill=_FAINT, font=font(12))
        row.paste(image, (x, y + _CAPTION))
    return row


def contact_sheet(
    images: Sequence[Sequence[np.ndarray]], rows: Sequence[str], columns: Sequence[str], title: str, subtitle: str
) -> Image.Image:
    """Arrange images in a grid.

    Args:
        images: One row of uint8 (h, w, 3) arrays, all of one shape, per entry of `rows`.
        rows: Captions of the rows.
        columns: Captions of the columns; may be empty.
        title: First line at the top.
        subtitle: Second line at the top.
    """
    height, width = images[0][0].shape[:2]
    cell = (width + _MARGIN, height + _CAPTION + _MARGIN)
    sheet = Image.new("RGB", (_MARGIN + len(columns) * cell[0], _TITLE + _MARGIN + len(rows) * cell[1]), _PAPER)
    draw = ImageDraw.Draw(sheet)
    draw.text((_MARGIN, 6), title, fill=_INK, font=font(17))
    draw.text((_MARGIN, 28), subtitle, fill=_FAINT, font=font(13))
    for i, (row, name) in enumerate(zip(images, rows)):
        for j, (image, column) in enumerate(zip(row, columns)):
            corner = (_MARGIN + j * cell[0], _TITLE + i * cell[1])
            draw.text(corner, f"{column}, {name}" if column else name, fill=_FAINT if column else _INK, font=font(13))
            sheet.paste(Image.fromarray(image), (corner[0], corner[1] + _CAPTION))
    return sheet


def first_and_last(sheet: Image.Image) -> tuple[Image.Image, Image.Image]:
    """Return the task views, `SIZE` px wide, of the first and the last row of a sheet of `demo_sheet`."""
    tops = (_TITLE + _CAPTION, sheet.height - 2 * _MARGIN - SIZE)
    first, last = (sheet.crop((_MARGIN, top, _MARGIN + SIZE, top + SIZE)) for top in tops)
    return first, last


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font for images, with a height of `size` [px]."""
    return ImageFont.load_default(size)


# Demonstrations ---------------------------------------------------------------------------------------------------


def _demonstrate(
    task: TaskEnvironment, seed: int, variation: int, attempt: int | None, on_frame: Callable[[Observation], None]
) -> Demo:
    if attempt is None:
        task.set_variation(variation)
        return task.get_demos(1, live_demos=True, seed=seed, callable_each_step=on_frame)[0]
    outcome = task.try_demo(seed=seed, variation=variation, attempt=attempt, on_frame=on_frame)
    if outcome.demo is None:
        raise DemoError(
            f"Seed {seed}, attempt {attempt} of '{task.get_name()}' does not succeed again: {outcome.cause} "
            "Choose another seed or attempt.",
            task.task,
        )
    return outcome.demo


def _wait(task: TaskEnvironment) -> Frame:
    """Simulate 1 s with arm and gripper stationary, and return the last frame."""
    task.runtime.hold()
    task.runtime.gripper.hold()
    for _ in range(round(_AFTER / task.world.control_dt)):
        task.runtime.step()
    return present_frame(task.world)


def _lets_fall(task: TaskEnvironment, frame: Frame) -> bool:
    """Whether a body falls when the gripper opens in a frame. The world is restored to the frame afterwards."""
    gripper, world = task.runtime.gripper, task.world
    gripper.release()
    gripper.set_target(1.0)
    for _ in range(round(_RELEASED / world.control_dt)):
        world.step()
    falls = _moves(frame, present_frame(world), _FALLEN)
    world.restore(frame.state)
    return falls


def present_frame(world: World) -> Frame:
    """Return the current frame of a world."""
    poses = {(body.name, link): body.link_pose(link) for body in world.bodies.values() for link in _visual_links(body)}
    touches = any(name in world.bodies for name in world.robot.touching())
    return Frame(world.time, world.save(), poses, bool(world.gripper.held), touches, world.robot.tip_pose()[:3])


def events(poses: Sequence[FloatArray], holds: Sequence[bool], touches: Sequence[bool]) -> dict[str, int]:
    """Choose the events of a demonstration, and return name -> number of the frame, in order.

    The events are, in order:

    * the reset;
    * the first contact, unless a grasp follows soon;
    * the first grasp, and a frame before it when it follows late;
    * the frame at which the links have covered half of their path since then, and in long demonstrations those at a quarter and
      at three quarters;
    * success, the last frame.

    If success follows the contact at once, a frame of the approach replaces the frame half way.

    Args:
        poses: Of each frame the poses (n, 7) of the links of the task.
        holds: Whether the gripper holds a body at each frame.
        touches: Whether the robot touches a body of the task at each frame.
    """
    last = len(poses) - 1
    contact, grasp = (happens.index(True, 1) if True in happens[1:] else None for happens in (touches, holds))
    found = {"reset": 0}
    if contact is not None and (grasp is None or grasp - contact > _LONG):
        found["first contact"] = contact
        if grasp is not None and grasp - contact > _VERY_LONG:
            found["before the grasp"] = contact + int(_AT * (grasp - contact))
    if grasp is not None:
        found["grasp"] = grasp
    begin = max(found.values())
    if last - begin < _SHORT < begin:
        found["approach"] = 3 * begin // 4
    else:
        path = np.cumsum([0.0, *(_distances(a, b, _STILL).sum() for a, b in zip(poses[begin:], poses[begin + 1 :]))])
        shares = {"a quarter": 0.25, "half way": 0.5, "three quarters": 0.75} if last - begin > _VERY_LONG else {"half way": 0.5}
        for event, share in shares.items():
            passed = np.searchsorted(path, share * path[-1]) if path[-1] > _MOVED else share * (last - begin)
            found[event] = begin + int(passed)
    middle = {event: k for event, k in found.items() if 0 < k < last}
    return {"reset": 0, **dict(sorted(middle.items(), key=lambda item: item[1])), "success": last}


def _distances(before: FloatArray, after: FloatArray, least: float) -> FloatArray:
    """How far links with poses (n, 7) have moved and turned (n,) [m]; 0 where it is below `least`."""
    cosine = np.abs((before[:, 3:] * after[:, 3:]).sum(axis=1))
    moved = np.linalg.norm(after[:, :3] - before[:, :3], axis=1) + 2.0 * _LEVER * np.arccos(np.minimum(cosine, 1.0))
    return np.where(moved < least, 0.0, moved)


def _moves(before: Frame, after: Frame, least: float) -> bool:
    """Whether a link that is in both frames has moved by `least` [m]."""
    _, (old, new) = _common_poses([before, after])
    return bool(_distances(old, new, least).any())


def _common_poses(frames: Sequence[Frame]) -> tuple[list[tuple[str, str]], list[FloatArray]]:
    """Return body and link of the links that are in all frames, and of each frame their poses (n, 7)."""
    names = [name for name in frames[0].poses if all(name in frame.poses for frame in frames)]
    return names, [np.array([frame.poses[name] for name in names]).reshape(-1, 7) for frame in frames]


# Cameras ----------------------------------------------------------------------------------------------------------


def task_view(world: World, frames: Sequence[Frame], size: int, *, hides_arm: bool = True) -> CameraView:
    """Return the camera that is aimed at the task, with an image of `size` px. The world is left in the last frame.

    The arm is hidden at the first frame, and with `hides_arm` at the last.

    The image contains, at all frames, the links that move, the bodies that are not large, and the parts of large bodies near the
    links that move. If no link moves, it contains the tip after the reset. Between the first and the last frame it also contains
    the gripper where that is near to these. The direction is the one that shows the links that move, their motion and the fingers
    best, and that is not opposite to the side from which they come.
    """
    names, poses = _common_poses(frames)
    links = [(world.bodies[body], link) for body, link in names]
    moves = np.max([_distances(poses[0], own, _MOVED) for own in poses], axis=0) > 0.0
    points = _points_to_frame(links, poses, moves)
    others = [pose[:3] for frame in frames for name, pose in frame.poses.items() if name not in names]
    if others:
        points = np.concatenate([points, others])
    if not moves.any():
        points = np.concatenate([points, [frame.tip for frame in frames[1:]]])
    points = np.concatenate([points, _gripper_points(world, frames[1:-1], points)])
    views = [framed(eye, points, (_SMALL, _SMALL)) for eye in _eyes(points)]
    ids = {name: number for number, name in world.masks.items()}
    numbers = [(body.name, ids[_mask_name(body, link)]) for body, link in links]
    moving, still = (
        [link for link, is_moving in zip(numbers, moves, strict=True) if is_moving == wanted] for wanted in (True, False)
    )
    masks: list[NDArray[np.int32]] = []
    for frame in frames:
        world.restore(frame.state)
        world.robot.show([] if frame is frames[0] or hides_arm and frame is frames[-1] else world.robot.grip.links)
        masks.append(np.array([world.render(view, rgb=False, depth=False).mask for view in views]))
        world.robot.show()
    arm = world.robot.description
    score = _clearness(np.array(masks), moving or still, still)
    fingers = [ids[f"{arm.name}/{link}"] for link in arm.finger_links]
    for mask in masks[1:-1]:
        score += _FINGERS / len(masks[1:-1]) * _log_share(np.isin(mask, fingers).sum(axis=(1, 2)), enough=_WELL)
    tilts = sorted({tilt for _, tilt in _DIRECTIONS})
    score -= _STEEP * np.array([tilts.index(tilt) for _, tilt in _DIRECTIONS])
    azimuths = np.radians([azimuth for azimuth, _ in _DIRECTIONS])
    side = np.column_stack([np.cos(azimuths), np.sin(azimuths)]) @ _side_of_motion(links, poses, moves)
    score += _FACING * np.clip(side, *_BEFORE)
    score += _ACROSS * np.log(_across([view.pose for view in views], poses, moves))
    return replace(views[int(np.argmax(score))], size=(size, size))


def _across(cameras: Sequence[FloatArray], poses: Sequence[FloatArray], moves: NDArray[np.bool_]) -> FloatArray:
    """Return the share (views,) of the way of the links that move, from the first to the last frame, that lies across the image.

    Args:
        cameras: Poses (7,) of cameras.
        poses: Of each frame the poses (n, 7) of the links.
        moves: Which links move (n,).
    """
    ways = (poses[-1] - poses[0])[moves, :3]
    ways = ways[np.linalg.norm(ways, axis=1) > _CLEAR_WAY]
    forward = np.array([pose_to_matrix(pose)[:3, 2] for pose in cameras])
    along = np.square(forward @ ways.T).sum(axis=1) / max(float(np.square(ways).sum()), 1e-12)
    return np.asarray(np.sqrt(np.maximum(1.0 - along, 0.04)))


def _side_of_motion(links: Sequence[tuple[Body, str]], poses: Sequence[FloatArray], moves: NDArray[np.bool_]) -> FloatArray:
    """Return the horizontal direction (2,), at most 1 long, in which the bodies that move are from the largest that they touch.

    Furniture and appliances have their fronts there. Doors, drawers and lids do not count.
    """
    boxes = _boxes(links)
    corners = np.array([[box_corners(box, pose) for box, pose in zip(boxes, own)] for own in poses])
    low, high, middles = corners.min(axis=2), corners.max(axis=2), corners.mean(axis=2)
    sizes = np.linalg.norm([np.ptp(box, axis=0) for box in boxes], axis=1)
    bodies = np.array([body.name for body, _ in links])
    still = np.flatnonzero(~np.isin(bodies, bodies[moves]))
    sides = [np.zeros(2)]
    for link in np.flatnonzero(moves & ~np.isin(bodies, bodies[~moves])):
        touched = still[_gaps(low, high, link, still).min(axis=0, initial=np.inf) < _BESIDE]
        if touched.size:
            away = (middles[:, link] - middles[:, touched[sizes[touched].argmax()]])[:, :2]
            sides.append((away / np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), _BESIDE)).mean(axis=0))
    side = np.mean(sides[1:] or sides, axis=0)
    return np.asarray(side / max(float(np.linalg.norm(side)), _CLEARLY))


def _gaps(low: FloatArray, high: FloatArray, link: int, others: NDArray[np.int_]) -> FloatArray:
    """Return the distances (f, k) of the box around a link from those around others, from corners (f, n, 3) [m]."""
    gaps = np.maximum(low[:, others] - high[:, link, None], 0.0) + np.maximum(low[:, link, None] - high[:, others], 0.0)
    return np.asarray(np.linalg.norm(gaps, axis=-1))


def _boxes(links: Sequence[tuple[Body, str]]) -> list[FloatArray]:
    """Return the box (2, 3) around each link in its frame [m]."""
    return [bounds(visual_geometry(body.model.urdf, body.model.scale)[link]) for body, link in links]


def _seen_through(world: World, frames: Sequence[Frame]) -> set[str]:
    """Return the names of masks of small links that move, and of those that they touch at the end; of all where none moves."""
    names, poses = _common_poses(frames)
    links = [(world.bodies[body], link) for body, link in names]
    boxes = _boxes(links)
    moves = np.max([_distances(poses[0], own, _MOVED) for own in poses], axis=0) > 0.0
    corners = np.array([[box_corners(box, pose) for box, pose in zip(boxes, poses[-1])]])
    low, high, every = corners.min(axis=2), corners.max(axis=2), np.arange(len(links))
    matters = moves | (not moves.any())
    for link in np.flatnonzero(moves):
        matters |= _gaps(low, high, link, every)[0] < _BESIDE
    small = [float(np.ptp(box, axis=0).max()) < _COVERED for box in boxes]
    return {_mask_name(*link) for link, seen in zip(links, matters & small, strict=True) if seen}


def _clearness(masks: NDArray[np.int32], moving: Sequence[tuple[str, int]], still: Sequence[tuple[str, int]]) -> FloatArray:
    """Return how well each view (views,) shows the links that move, above all at the last frame, and their motion.

    It also counts what is seen of what a door or a lid hides at the first or at the last frame, more than of the door, and of the
    other links at both. What has been taken away should not be before or behind the rest at the last frame, if a view that shows
    it well is like that.

    Args:
        masks: Masks (frames, views, h, w), of the arm at most with the gripper.
        moving: Body and mask id of the links that move.
        still: Body and mask id of the others.
    """
    score = np.zeros(masks.shape[1])
    doors = {body for body, _ in moving} & {body for body, _ in still}
    for body, number in moving:
        shown = masks == number
        pixels = shown.sum(axis=(2, 3))
        changed = (shown[0] != shown[-1]).sum(axis=(1, 2))
        for weight, part in ((1.0, pixels.mean(axis=0)), (1.0, pixels[0]), (1.0, changed)):
            score += weight * _log_share(part) / len(moving)
        at_last = _END / 3.0 * _log_share(pixels[-1]) if body in doors else _END * _log_share(pixels[-1], enough=1.0)
        score += at_last / len(moving)
        rest = np.isin(masks[0], [other for name, other in still if name != body])
        before = (shown[-1] & rest).sum(axis=(1, 2)) / np.maximum(pixels[-1], 1)
        if before[pixels[-1] > _WELL * pixels[-1].max()].min(initial=1.0) < 0.02:
            score += _APART * np.log(1.1 - np.minimum(4.0 * before, 1.0)) / len(moving)
    for body in doors:
        before, after = (
            [np.isin(masks[k], [number for name, number in group if name == body]) for group in (moving, still)] for k in (0, -1)
        )
        revealed = (before[0] & after[1]) | (before[1] & after[0])
        score += _REVEALED * _log_share(revealed.sum(axis=(1, 2)))
    for _, number in still:
        for k in (0, -1):
            score += 0.5 * _log_share((masks[k] == number).sum(axis=(1, 2))) / len(still)
    return score


def _log_share(pixels: NDArray[np.int_], enough: float = _ENOUGH) -> FloatArray:
    """Logarithm of the share (views,) that each view shows of what the best one shows, up to what is enough."""
    return np.asarray(np.log(np.minimum(pixels / max(pixels.max(), 1), enough) + 0.1))


def _points_to_frame(links: Sequence[tuple[Body, str]], poses: Sequence[FloatArray], moves: NDArray[np.bool_]) -> FloatArray:
    """Return points (n, 3) around what the image of the task has to contain [m]; see `task_view`."""
    small = {body.name: float(body.aabb_size().max()) < _LARGE for body, _ in links}
    boxes = _boxes(links)
    corners = [np.concatenate([box_corners(box, own[k]) for own in poses]) for k, box in enumerate(boxes)]
    whole = [own for own, moving, (body, _) in zip(corners, moves, links, strict=True) if moving or small[body.name]]
    moving = np.concatenate([own for own, is_moving in zip(corners, moves, strict=True) if is_moving or not moves.any()])
    low, high = moving.min(axis=0) - _NEAR, moving.max(axis=0) + _NEAR
    near = [own for own in corners if (own.min(axis=0) < high).all() and (own.max(axis=0) > low).all()]
    points = np.concatenate([*whole, *(own.clip(low, high) for own in near)])
    sizes = [np.ptp(box, axis=0).max() for box, is_moving in zip(boxes, moves, strict=True) if is_moving or not moves.any()]
    for own in sorted(near, key=lambda own: float(np.ptp(own, axis=0).max())):
        longer = np.concatenate([points, own])
        length = np.linalg.norm(np.ptp(longer, axis=0))
        if length <= min(_WHOLE * np.linalg.norm(np.ptp(points, axis=0)), max(sizes) / _TINY):
            points = longer
    return np.concatenate([points + _AROUND * side for side in (*np.eye(3), *-np.eye(3))])


def _gripper_points(world: World, frames: Sequence[Frame], points: FloatArray) -> FloatArray:
    """Return corners (n, 3) of the gripper in frames where it is near to points (m, 3) [m]; the world is in the last then."""
    low, high = points.min(axis=0) - _BESIDE_TASK, points.max(axis=0) + _BESIDE_TASK
    shapes = visual_geometry(world.robot.model.urdf)
    found = [np.zeros((0, 3))]
    for frame in frames:
        world.restore(frame.state)
        for link in world.robot.grip.links:
            corners = box_corners(bounds(shapes[link]), world.robot.link_pose(link))
            if (corners.min(axis=0) < high).all() and (corners.max(axis=0) > low).all():
                found.append(corners.clip(low, high))
    return np.concatenate(found)


def _eyes(points: FloatArray) -> list[FloatArray]:
    """Positions (3,) from which a camera may look at points (n, 3) [m]."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    distance = max(_NEAREST, _PER_RADIUS * float(np.linalg.norm(points - middle, axis=1).max()))
    eyes = []
    for azimuth, tilt in np.radians(_DIRECTIONS):
        away = np.array([np.cos(azimuth) * np.cos(tilt), np.sin(azimuth) * np.cos(tilt), np.sin(tilt)])
        eyes.append(np.clip(middle + distance * away, *_INSIDE))
    return eyes


def _visual_links(body: Body) -> list[str]:
    """Names of the links of a body that have visuals."""
    shapes = visual_geometry(body.model.urdf, body.model.scale)
    return [link for link in body.links if shapes.get(link)]


def _mask_name(body: Body, link: str) -> str:
    return body.name if len(body.links) == 1 else f"{body.name}/{link}"


def _moment(task: TaskEnvironment, label: str, frame: Frame, view: CameraView, through: set[str] | None) -> Moment:
    """Draw a frame; its task view has the gripper, with masks `through` seen through the hand, or no arm when None."""
    world, size = task.world, view.size[0]
    world.restore(frame.state)
    small = max((size - 2 * _CAPTION - _GAP) // 2, 1)
    views = {name: task.runtime.cameras[name].view() for name in CAMERAS}
    views[OVERVIEW] = clear_view()[OVERVIEW].view(world, task.runtime.description)
    cameras = rendered(world, list(views.values()), small)
    whole, shadows = _fine(world, view), world.renderer.shadow_map()
    image = _without_arm(task, view).rgb if through is None else _with_gripper(task, view, shadows, through)
    shown, with_arm = (_reduced(rgb, size) for rgb in (image, whole.rgb))
    return Moment(label, view, through is None, shown, with_arm, dict(zip(views, cameras, strict=True)))


def _without_arm(task: TaskEnvironment, view: CameraView, shadows: ShadowMap | None = None) -> Images:
    """Return the images of a camera without the arm, and without its shadow unless `shadows` are given."""
    task.world.robot.show([])
    images = _fine(task.world, view, shadows)
    task.world.robot.show()
    return images


def _with_gripper(task: TaskEnvironment, view: CameraView, shadows: ShadowMap, through: set[str]) -> NDArray[np.uint8]:
    """Return what a camera sees with the gripper alone, and a lighter shadow of the arm; masks `through` are seen through it."""
    world, arm = task.world, task.runtime.description
    bare, shaded = _without_arm(task, view), _without_arm(task, view, shadows)
    world.robot.show(world.robot.grip.links)
    own = _fine(world, view, shadows)
    world.robot.show()
    colors = [images.rgb.astype(np.float32) for images in (bare, shaded, own) if images.rgb is not None]
    assert own.mask is not None and bare.mask is not None
    gripper, fingers = ({f"{arm.name}/{link}" for link in links} for links in (world.robot.grip.links, arm.finger_links))
    shown, opaque, behind = (
        np.isin(mask, [number for number, name in world.masks.items() if name in wanted])
        for mask, wanted in ((own.mask, gripper), (own.mask, fingers), (bare.mask, through))
    )
    clear = ndimage.gaussian_filter(ndimage.binary_dilation(behind, iterations=2).astype(np.float32), _BLUR)
    opacity = np.where(opaque, 1.0, _HAND + (_THROUGH - _HAND) * clear) * shown
    opacity = ndimage.gaussian_filter(opacity, 0.8)[..., None]
    line = ndimage.gaussian_filter((shown ^ ndimage.binary_erosion(shown, iterations=3)).astype(np.float32), 0.8)[..., None]
    image = colors[0] + _SHADOW * (colors[1] - colors[0])
    image += (colors[2] - image) * opacity
    image *= 1.0 - _OUTLINE * line
    return np.asarray(np.round(image).clip(0.0, 255.0), dtype=np.uint8)


def rendered(world: World, views: Sequence[CameraView], size: int) -> list[Image.Image]:
    """Return what square cameras see now, of `size` px, with smooth edges: rendered three times as large, then reduced."""
    fine = [replace(view, size=(_FINER * size, _FINER * size)) for view in views]
    images = world.renderer.render_all([Request(view, depth=False, mask=False, shadows=True, antialiasing=True) for view in fine])
    return [_reduced(image.rgb, size) for image in images]


def _fine(world: World, view: CameraView, shadows: ShadowMap | None = None) -> Images:
    """Return colours, depth and mask of a camera, several times as large as they are shown.

    Args:
        world: The world.
        view: The camera.
        shadows: The shadows; those of this instant when None.
    """
    larger = replace(view, size=(_FINER * view.size[0], _FINER * view.size[1]))
    return world.renderer.render_all([Request(larger, shadows=True, antialiasing=True)], shadows)[0]


def _reduced(rgb: NDArray[np.uint8] | None, size: int) -> Image.Image:
    """Return an image of `size` px of a larger one."""
    assert rgb is not None
    return Image.fromarray(rgb).resize((size, size), Image.Resampling.LANCZOS)
