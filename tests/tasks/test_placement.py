"""Random places of bodies and of the whole task."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError, InvalidValue, TaskError
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, PlacementSpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import TABLE_HEIGHT, compose, inverse, pose_at, quaternion_yaw, relative
from rlbench_pin.tasks import (
    NO_ROTATION,
    PLACEMENT_AREA,
    SpawnBoundary,
    Tray,
    clearance,
    easiest_top_grasp,
    free_direction,
    place_task,
    settle,
    swap_places,
)
from rlbench_pin.tasks.boxes import OrientedBox
from rlbench_pin.tasks.placement import footprint
from tests.tasks.stand_ins import FakeBody, FakeFrame


def corners(body: FakeBody) -> np.ndarray:
    """Corners of the box of a body in the world."""
    return OrientedBox.of(body.bounds(), body.pose).corners()


def test_the_turned_box_stays_inside_a_rectangle_and_keeps_its_height() -> None:
    """Over many draws the whole region is used, in the frame of the region."""
    region = FakeFrame("region", pose_at((1.0, 2.0, 0.5), yaw=0.7), (0.4, 0.3, 0.0))
    rng, places = np.random.default_rng(0), []
    for _ in range(200):
        body = FakeBody(pose=pose_at((0.0, 0.0, 0.8)), box=(0.12, 0.04, 0.3))
        SpawnBoundary([region]).sample(body, rng)
        assert body.pose[2] == pytest.approx(0.8)
        local = np.array([relative(np.append(c, [0, 0, 0, 1]), region.pose)[:2] for c in corners(body)])
        assert np.all(np.abs(local) <= np.array([0.2, 0.15]) + 1e-9)
        places.append(relative(body.pose, region.pose)[:2])
    assert np.ptp(places, axis=0) == pytest.approx([0.3, 0.2], abs=0.06)


def test_a_box_region_draws_the_height_too() -> None:
    """Nothing sticks out above or below."""
    region = FakeFrame("region", pose_at((0.0, 0.0, 1.0)), (0.4, 0.4, 0.2))
    rng, heights = np.random.default_rng(0), []
    for _ in range(100):
        body = FakeBody(box=(0.05, 0.05, 0.05))
        SpawnBoundary([region]).sample(body, rng)
        heights.append(body.pose[2])
    assert 0.925 <= min(heights) < 0.94
    assert 1.06 < max(heights) <= 1.075


def test_the_rotation_is_drawn_between_its_bounds_on_top_of_the_present_one() -> None:
    """A body that lies on its side stays there."""
    region = FakeFrame("region", size=(1.0, 1.0, 0.0))
    rng = np.random.default_rng(0)
    body = FakeBody(pose=pose_at((0, 0, 0), yaw=1.0))
    SpawnBoundary([region]).sample(body, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION)
    assert quaternion_yaw(body.pose[3:]) == pytest.approx(1.0)
    start = pose_at((0, 0, 0), pitch=np.pi / 2)
    for _ in range(20):
        lying = FakeBody(pose=start.copy())
        SpawnBoundary([region]).sample(lying, rng, min_rotation=(0, 0, -0.1), max_rotation=(0, 0, 0.1))
        turn = compose(lying.pose, inverse(start))[3:]
        np.testing.assert_allclose(turn[:2], 0.0, atol=1e-9)
        assert abs(quaternion_yaw(turn)) <= 0.1


def test_regions_are_drawn_in_proportion_to_their_area() -> None:
    """Three times the area, three times as often."""
    small, large = FakeFrame("small", pose_at((-5, 0, 0)), (1, 1, 0)), FakeFrame("large", pose_at((5, 0, 0)), (1, 3, 0))
    rng, hits = np.random.default_rng(0), 0
    for _ in range(400):
        body = FakeBody()
        SpawnBoundary([small, large]).sample(body, rng)
        hits += body.pose[0] > 0
    assert 270 <= hits <= 330


def test_elements_of_one_boundary_do_not_touch_and_keep_their_distance() -> None:
    """Boxes stay apart, origins too; clear forgets them."""
    boundary = SpawnBoundary([FakeFrame("region", size=(0.6, 0.6, 0.0))])
    rng = np.random.default_rng(0)
    for _ in range(10):
        boundary.clear()
        bodies = [FakeBody(f"b{i}", box=(0.1, 0.05, 0.05)) for i in range(6)]
        for body in bodies:
            boundary.sample(body, rng, min_distance=0.12)
        boxes = [OrientedBox.of(b.bounds(), b.pose) for b in bodies]
        for i, one in enumerate(bodies):
            for j in range(i):
                assert np.linalg.norm(one.position - bodies[j].position) >= 0.12
                assert not boxes[i].overlaps(boxes[j])


def test_collisions_may_be_ignored() -> None:
    """Then elements may stand in each other."""
    boundary = SpawnBoundary([FakeFrame("region", size=(0.11, 0.11, 0.0))])
    rng = np.random.default_rng(0)
    for _ in range(2):
        boundary.sample(FakeBody(), rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, ignore_collisions=True)


def test_a_crowded_or_too_small_region_says_why() -> None:
    """The error names the element, its size, the regions and what stands there; the element has not moved."""
    rng = np.random.default_rng(0)
    boundary = SpawnBoundary([FakeFrame("shelf", size=(0.15, 0.15, 0.0))])
    boundary.sample(FakeBody("first", box=(0.05, 0.05, 0.05)), rng)
    late = FakeBody("second", box=(0.05, 0.05, 0.05))
    with pytest.raises(BoundaryError, match=r"'second' .* in shelf: .* \(first\)"):
        boundary.sample(late, rng, min_distance=0.5)
    assert not late.pose[:3].any()
    with pytest.raises(BoundaryError, match="100 times it did not fit"):
        boundary.sample(FakeBody("big", box=(0.2, 0.2, 0.2)), rng)
    with pytest.raises(TaskError, match="at least one region"):
        SpawnBoundary([])


def test_frames_are_placed_as_points() -> None:
    """A frame has no size."""
    frame = FakeFrame("frame")
    SpawnBoundary([FakeFrame("region", pose_at((3, 0, 0)), (0.01, 0.01, 0.0))]).sample(frame, np.random.default_rng(0))
    assert frame.pose[0] == pytest.approx(3.0, abs=0.01)


def test_the_same_generator_gives_the_same_places() -> None:
    """Chance comes from the argument alone."""
    poses = []
    for _ in range(2):
        body = FakeBody()
        SpawnBoundary([FakeFrame("region", size=(1, 1, 0))]).sample(body, np.random.default_rng(5))
        poses.append(body.pose.tobytes())
    assert poses[0] == poses[1]


def test_oriented_boxes_know_when_they_meet() -> None:
    """Edge to edge across a corner is the hard case."""
    unit = np.array([[-0.5] * 3, [0.5] * 3])
    here = OrientedBox.of(unit, pose_at((0, 0, 0)))
    assert here.overlaps(OrientedBox.of(unit, pose_at((0.99, 0, 0))))
    assert not here.overlaps(OrientedBox.of(unit, pose_at((1.01, 0, 0))))
    assert here.overlaps(OrientedBox.of(unit, pose_at((1.2, 0, 0), yaw=np.pi / 4)))
    assert not here.overlaps(OrientedBox.of(unit, pose_at((0.95, 0.95, 0), yaw=np.pi / 4)))


def test_swapping_keeps_heights_and_orientations() -> None:
    """Only x and y change hands."""
    a, b = FakeBody(pose=pose_at((1, 2, 3), yaw=0.5)), FakeBody(pose=pose_at((4, 5, 6), yaw=-0.5))
    swap_places(a, b)
    np.testing.assert_allclose(a.pose, pose_at((4, 5, 3), yaw=0.5))
    np.testing.assert_allclose(b.pose, pose_at((1, 2, 6), yaw=-0.5))


CUBE = BodySpec(name="cube", asset="objects/cube/cube.urdf", pose=(0.1, 0.0, 0.025, 0, 0, 0, 1))


def test_the_whole_task_is_placed_so_that_its_footprint_fits() -> None:
    """The patch stays in the workspace, the yaw in its bounds, the height where it was; bodies come along."""
    placement = PlacementSpec(footprint=(0.3, 0.1), footprint_center=(-0.2, 0.05), yaw=(-0.5, 0.5))
    rng = np.random.default_rng(0)
    with World(SceneSpec(format=1, body=(CUBE,), placement=placement), robot_description("panda")) as world:
        for _ in range(50):
            place_task(world, rng, ((0, 0, -0.5), (0, 0, 0.5)))
            root = world.root.pose
            assert abs(quaternion_yaw(root[3:])) <= 0.5
            assert root[2] == TABLE_HEIGHT
            np.testing.assert_allclose(relative(world.body("cube").pose, root), CUBE.pose, atol=1e-9)
            patch = [(x, y) for x in (-0.35, -0.05) for y in (0.0, 0.1)]
            for x, y in patch:
                c, s = np.cos(quaternion_yaw(root[3:])), np.sin(quaternion_yaw(root[3:]))
                corner = root[:2] + [c * x - s * y, s * x + c * y]
                assert np.all(corner >= PLACEMENT_AREA.low - 1e-9)
                assert np.all(corner <= PLACEMENT_AREA.high + 1e-9)


def test_without_a_footprint_the_box_of_all_bodies_counts() -> None:
    """Its corners are taken in the frame of the root."""
    with World(SceneSpec(format=1, body=(CUBE,)), robot_description("panda")) as world:
        low, high = footprint(world)
    np.testing.assert_allclose(low, [0.075, -0.025], atol=1e-3)
    np.testing.assert_allclose(high, [0.125, 0.025], atol=1e-3)


def test_a_footprint_that_never_fits_says_so() -> None:
    """The error names the sizes and the remedy."""
    scene = SceneSpec(format=1, placement=PlacementSpec(footprint=(2.0, 0.1)))
    with (
        World(scene, robot_description("panda")) as world,
        pytest.raises(BoundaryError, match=r"\[2.0, 0.1\].*smaller footprint"),
    ):
        place_task(world, np.random.default_rng(0))


REGION = FakeFrame("patch", size=(0.6, 0.6, 0.0))
TRAY = Tray(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), np.array([0.1, 0.1]))
RNG = np.random.default_rng(0)


class WorldStandIn:
    """As much of a world as is asked for."""

    def step(self) -> None:
        """Nothing happens."""

    def place_root(self, pose: object) -> None:
        """Nothing is moved."""


def sample(**arguments: object) -> object:
    """Place a body with some arguments exchanged."""
    given = {"element": FakeBody(), "rng": np.random.default_rng(0), **arguments}
    return SpawnBoundary([REGION]).sample(**given)  # type: ignore[arg-type]


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "regions": (lambda: SpawnBoundary(REGION), "regions has to be a list"),  # type: ignore[arg-type]
    "a body for a region": (lambda: SpawnBoundary(["patch"]), r"entry 0 of regions.*self.world.region"),  # type: ignore[list-item]
    "a name for an element": (lambda: sample(element="cube"), r"element has to be a body or a frame"),
    "a seed for a generator": (lambda: sample(rng=3), r"rng has to be a Generator.*default_rng"),
    "degrees": (lambda: sample(min_rotation=(0.0, 0.0, -1800.0)), "min_rotation has to have numbers"),
    "turned round": (lambda: sample(max_rotation=(0.0, 0.0, -4.0)), "max_rotation has to be at least min_rotation"),
    "no distance": (lambda: sample(min_distance=-1.0), "min_distance"),
    "no switch": (lambda: sample(ignore_collisions="yes"), "ignore_collisions"),
    "no function": (lambda: SpawnBoundary([REGION]).scatter([FakeBody()], RNG, accept=True), "accept"),  # type: ignore[arg-type]
    "no others": (lambda: clearance(FakeBody(), FakeBody()), "others has to be a list"),  # type: ignore[arg-type]
    "no tray": (lambda: easiest_top_grasp([], [], None), "tray has to be a Tray"),  # type: ignore[arg-type]
    "half a tray": (lambda: Tray(TRAY.pose, np.array([0.1, 0.0])), "Tray.half"),
    "no heading": (lambda: free_direction(np.zeros(2), ["north"], [], 0.1, 0.1), "each of directions"),  # type: ignore[list-item]
    "no place": (lambda: free_direction(np.zeros(3), [0.0], [], 0.1, 0.1), "place has to have shape"),
    "no world": (lambda: place_task(None, RNG), "world has to be a world"),  # type: ignore[arg-type]
    "one bound": (lambda: place_task(WorldStandIn(), RNG, (0.0, 1.0, 2.0)), "bounds has to be the lowest and"),  # type: ignore[arg-type]
    "nothing to settle": (lambda: settle(WorldStandIn(), [], RNG), "bodies has to contain at least one"),  # type: ignore[arg-type]
    "one to swap": (lambda: swap_places(FakeBody(), "other"), "second has to be a body"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("call", "words"), WRONG.values(), ids=WRONG.keys())
def test_objects_that_are_no_elements_are_refused(call: Callable[[], object], words: str) -> None:
    """The error names the argument and says where a task finds the right element."""
    with pytest.raises(InvalidValue, match=words):
        call()


def test_a_boundary_needs_a_region() -> None:
    """The error says where regions are."""
    with pytest.raises(TaskError, match=r"at least one region, such as `self.world.region\(name\)`"):
        SpawnBoundary([])


def test_a_wanted_body_is_one_of_the_bodies() -> None:
    """A body that is not named among those in the tray cannot be scored."""

    class Bulky(FakeBody):
        def extent_along(self, directions: object) -> np.ndarray:
            return self.bounds()

    with pytest.raises(InvalidValue, match=r"wanted has to be a subset of `bodies` \(one\). Got \['other'\]"):
        easiest_top_grasp([Bulky("other")], [Bulky("one")], TRAY)


def test_directions_and_others_may_be_arrays() -> None:
    """As lists of numbers and of points may be."""
    others = np.array([[-0.1, 0.0]])
    assert free_direction([0.0, 0.0], np.array([0.0, 1.0]), others, 0.05, 0.5) == 1.0  # type: ignore[arg-type]
