"""Waypoints: poses, curves, what the gripper does."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.scene.spec import ArcSpec, WaypointSpec
from rlbench_pin.spatial import pose_at, relative
from rlbench_pin.tasks import Waypoint
from tests.tasks.stand_ins import FakeFrame


def waypoint(frame: FakeFrame | None = None, before: float = 1.0, **keys: object) -> Waypoint:
    """Make waypoint 0."""
    return Waypoint(0, frame or FakeFrame(), WaypointSpec(name="waypoint0", **keys), before)


def test_a_waypoint_follows_its_frame() -> None:
    """The pose is read when asked, and the array is the caller's."""
    frame = FakeFrame()
    point = waypoint(frame)
    point.pose[0] = 9.0
    frame.set_pose(pose_at((1, 2, 3)))
    np.testing.assert_allclose(point.pose, pose_at((1, 2, 3)))


@pytest.mark.parametrize(
    ("gripper", "before", "amount", "releases"),
    [
        (None, 0.3, 0.3, False),
        ("open", 0.0, 1.0, True),
        ("open", 1.0, 1.0, True),
        ("close", 1.0, 0.0, False),
        (0.5, 1.0, 0.5, False),
        (0.5, 0.0, 0.5, True),
        (1, 0.2, 1.0, True),
    ],
)
def test_the_hand_ends_at_an_amount_and_opening_releases(gripper: object, before: float, amount: float, releases: bool) -> None:
    """A fraction opens or closes according to what the waypoints before left behind."""
    point = waypoint(before=before, gripper=gripper)
    assert (point.gripper_amount, point.releases) == (amount, releases)


def test_a_curve_of_points_passes_them_in_its_frame() -> None:
    """The last point is the pose of the waypoint."""
    frame = FakeFrame(pose=pose_at((1, 0, 0), yaw=np.pi / 2))
    point = waypoint(frame, path="curve", points=((0.1, 0, 0), (0.2, 0, 0)))
    poses = point.curve_poses(pose_at((0, 0, 0)))
    np.testing.assert_allclose([p[:3] for p in poses], [[1, 0.1, 0], [1, 0.2, 0]], atol=1e-12)
    np.testing.assert_allclose(point.pose, poses[-1])


def test_an_arc_sweeps_the_previous_pose_about_its_axis() -> None:
    """The distance to the axis stays; with twist the gripper turns along, in small steps."""
    frame = FakeFrame(pose=pose_at((1, 0, 0)))
    arc = ArcSpec(axis=(0, 0, 2), angle=np.pi / 2)
    start = pose_at((2, 0, 0.5), roll=0.3)
    poses = waypoint(frame, path="curve", arc=arc).curve_poses(start)
    np.testing.assert_allclose(poses[-1][:3], [1, 1, 0.5], atol=1e-9)
    np.testing.assert_allclose(relative(poses[-1], pose_at((1, 0, 0), yaw=np.pi / 2)), relative(start, frame.pose), atol=1e-9)
    for before, after in zip([start, *poses], poses, strict=False):
        assert np.linalg.norm(after[:3] - [1, 0, 0.5]) == pytest.approx(1.0)
        assert np.linalg.norm(after[:3] - before[:3]) < 0.11
    rigid = waypoint(frame, path="curve", arc=ArcSpec(axis=(0, 0, 1), angle=-0.5, twist=False)).curve_poses(start)
    np.testing.assert_allclose(rigid[-1][3:], start[3:])
    np.testing.assert_allclose(rigid[-1][:2], [1 + np.cos(0.5), -np.sin(0.5)])


def test_hooks_get_the_waypoint() -> None:
    """Start and end hooks run when called, and only if there are any."""
    point, calls = waypoint(), []
    point.run_start_hook()
    point.run_end_hook()
    point.set_hooks(lambda w: calls.append(("start", w)), lambda w: calls.append(("end", w)))
    point.run_start_hook()
    point.run_end_hook()
    assert calls == [("start", point), ("end", point)]
