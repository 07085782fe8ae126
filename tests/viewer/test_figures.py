"""Figures draw what simulation has, and change only what changed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from viser import FrameHandle, MeshHandle, ViserServer

from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.urdf import UrdfShape, read_urdf
from rlbench_pin.viewer.figures import Figures, drawn_surface

CUBE = BodySpec(name="cube", asset="objects/cube/cube.urdf", color=(0.2, 0.4, 0.6))
CUP = BodySpec(name="cup", asset="objects/cup/cup.urdf", scale=2.0)


@pytest.fixture
def server() -> Iterator[ViserServer]:
    """A page that nobody looks at."""
    server = ViserServer("127.0.0.1", 0, verbose=False)
    yield server
    server.stop()


def _mesh(server: ViserServer, name: str) -> MeshHandle:
    handle = server.scene.get_handle_by_name(name)
    assert isinstance(handle, MeshHandle)
    return handle


def _frame(server: ViserServer, name: str) -> FrameHandle:
    handle = server.scene.get_handle_by_name(name)
    assert isinstance(handle, FrameHandle)
    return handle


def _points(place: FrameHandle | MeshHandle, mesh: MeshHandle) -> FloatArray:
    """Return the corners of a mesh at the place of a node, in the world."""
    w, x, y, z = place.wxyz
    matrix = pose_to_matrix([*place.position, x, y, z, w])
    return np.asarray(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3])


def test_bodies_have_their_colours_and_scale(server: ViserServer) -> None:
    """The colour of the scene file, else that of the URDF; lengths times the scale."""
    assert Figures(server.scene).show(SceneSpec(format=2, body=(CUBE, CUP))) == {}
    assert _mesh(server, "/bodies/cube/0/0").color == (51, 102, 153)
    cup = _mesh(server, "/bodies/cup/0/0")
    assert cup.color == (217, 51, 46)
    assert float(np.ptp(cup.vertices[:, 2])) == pytest.approx(2 * 0.09, abs=0.002)


def test_only_what_changed_is_drawn_again(server: ViserServer) -> None:
    """A moved body keeps its node, a recoloured one gets a new one, one that is gone has none."""
    figures = Figures(server.scene)
    figures.show(SceneSpec(format=2, body=(CUBE, CUP)))
    cube, cup = (_mesh(server, f"/bodies/{name}/0/0") for name in ("cube", "cup"))
    moved = CUBE.model_copy(update={"pose": (0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)})
    figures.show(SceneSpec(format=2, body=(moved, CUP.model_copy(update={"color": (1.0, 0.0, 0.0)}))))
    assert _mesh(server, "/bodies/cube/0/0") is cube
    assert _mesh(server, "/bodies/cup/0/0") is not cup
    frame = server.scene.get_handle_by_name("/bodies/cube/0")
    assert isinstance(frame, FrameHandle)
    assert frame.position[0] == pytest.approx(0.35)  # the root stands at 0.25
    figures.show(SceneSpec(format=2, body=(CUP,)))
    assert server.scene.get_handle_by_name("/bodies/cube") is None


def test_a_body_that_cannot_be_read_is_told_and_the_rest_is_drawn(server: ViserServer, tmp_path: Path) -> None:
    """A missing file costs one body, not the page."""
    lost = BodySpec(name="lost", asset="./lost.urdf")
    faults = Figures(server.scene).show(SceneSpec(format=2, body=(lost, CUBE), file=str(tmp_path / "scene.toml")))
    assert list(faults) == ["lost"]
    assert "lost.urdf" in faults["lost"]
    assert _mesh(server, "/bodies/cube/0/0")


def test_the_arm_stands_where_the_model_says(server: ViserServer) -> None:
    """Forward kinematics of the drawn links agree with the robot's model."""
    robot = robot_description("panda")
    q = np.array(robot.home) + 0.2
    Figures(server.scene).arm(q, [0.01, 0.02])
    hand = server.scene.get_handle_by_name(f"/arm/{read_urdf(robot.urdf).link_names.index('panda_link7')}")
    assert isinstance(hand, FrameHandle)
    assert np.allclose(hand.position, RobotModel(robot).joint_poses(q)[6][:3], atol=1e-9)


def test_marks_are_painted_and_taken_back(server: ViserServer) -> None:
    """Links of bodies and of the arm, however they are named."""
    figures = Figures(server.scene)
    figures.show(SceneSpec(format=2, body=(CUBE,)))
    number = read_urdf(robot_description("panda").urdf).link_names.index("panda_hand")
    own = _mesh(server, f"/arm/{number}/0").color
    figures.mark(["cube/cube", "panda/panda_hand"], (255, 0, 0))
    assert _mesh(server, "/bodies/cube/0/0").color == _mesh(server, f"/arm/{number}/0").color == (255, 0, 0)
    figures.mark(["panda_link1"], (255, 0, 0))
    assert _mesh(server, "/bodies/cube/0/0").color == (51, 102, 153)
    assert _mesh(server, f"/arm/{number}/0").color == own


def test_a_ghost_has_its_tip_at_the_pose(server: ViserServer) -> None:
    """The hand is drawn so that the tip is where the waypoint is; another colour replaces it."""
    figures, robot = Figures(server.scene), robot_description("panda")
    tip = RobotModel(robot).tip_pose(robot.home)
    figures.ghost("waypoint0", tip, (0, 200, 0))
    figures.arm(robot.home, [0.04, 0.04])
    urdf, expected = read_urdf(robot.urdf), list[FloatArray]()
    for link in (robot.hand_link, *robot.finger_links):
        number = urdf.link_names.index(link)
        parts = range(sum(bool(shape.kind) for shape in urdf.links[number].visuals))
        expected += [_points(_frame(server, f"/arm/{number}"), _mesh(server, f"/arm/{number}/{part}")) for part in parts]
    ghost = _mesh(server, "/ghosts/waypoint0")
    assert np.allclose(_points(ghost, ghost), np.concatenate(expected), atol=1e-5)
    figures.ghost("waypoint0", tip, (200, 0, 0))
    assert _mesh(server, "/ghosts/waypoint0").color == (200, 0, 0)
    figures.remove_ghost("waypoint0")
    assert figures.ghosts == ()
    assert server.scene.get_handle_by_name("/ghosts/waypoint0") is None


def test_surfaces_are_sharp_at_edges_and_smooth_elsewhere() -> None:
    """The corners of a box belong to three faces each, those of a cylinder's mantle are shared."""
    box = drawn_surface(UrdfShape("box", (0.1, 0.1, 0.1), None, None, None), 1.0)
    assert len(box.corners) == 24
    cylinder = UrdfShape("cylinder", (0.1, 0.2), None, None, None)
    points, _ = shape_surface(cylinder)
    assert len(drawn_surface(cylinder, 1.0).corners) == 2 * len(points)


def test_an_episode_has_colours_and_bodies_of_its_own(server: ViserServer) -> None:
    """They last until the scene is shown again, beneath marks, which come off to them."""
    figures, spec = Figures(server.scene), SceneSpec(format=2, body=(CUBE, CUP))
    figures.show(spec)
    link = read_urdf(resolve_asset(spec, CUBE.asset)).base_link
    figures.paint({f"cube/{link}": (1.0, 0.0, 0.0, 1.0)})
    figures.present({"cube"})
    assert _mesh(server, "/bodies/cube/0/0").color == (255, 0, 0)
    assert not _frame(server, "/bodies/cup").visible
    figures.mark(["cube"])
    figures.paint({f"cube/{link}": (0.0, 1.0, 0.0, 1.0)})
    assert _mesh(server, "/bodies/cube/0/0").color == (230, 40, 40)
    figures.mark([])
    assert _mesh(server, "/bodies/cube/0/0").color == (0, 255, 0)
    figures.show(spec)
    assert _mesh(server, "/bodies/cube/0/0").color == (51, 102, 153)
    assert _frame(server, "/bodies/cup").visible
