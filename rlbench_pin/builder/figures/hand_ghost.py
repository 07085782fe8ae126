"""The hand alone, open and translucent, where a tip is to be; one mesh, because each mesh of a picture has its price."""

from __future__ import annotations

from functools import lru_cache

from viser import MeshHandle, SceneApi

from rlbench_pin.builder.figures.chain import link_poses
from rlbench_pin.builder.figures.model_figure import OnPick, Rgb
from rlbench_pin.builder.figures.surfaces import DrawnSurface, drawn_surface, merged_surface
from rlbench_pin.robot import RobotDescription
from rlbench_pin.spatial import FloatArray, relative
from rlbench_pin.urdf import read_urdf

_OPACITY = 0.45


class HandGhost:
    """A hand in one colour.

    Args:
        scene: Where it is drawn.
        name: What it is called, and what `on_pick` is told.
        robot: Whose hand it is.
        rgb: Its colour.
        on_pick: Called when somebody clicks on it.
    """

    def __init__(self, scene: SceneApi, name: str, robot: RobotDescription, rgb: Rgb, on_pick: OnPick | None) -> None:
        surface = _hand_from_tip(robot)
        self._mesh: MeshHandle = scene.add_mesh_simple(
            f"/ghosts/{name}", surface.corners, surface.triangles, color=rgb, opacity=_OPACITY, cast_shadow=False
        )
        if on_pick is not None:
            self._mesh.on_click(lambda event: on_pick(name))

    def show(self, pose: FloatArray, rgb: Rgb) -> None:
        """Put its tip at a world pose (7,), in a colour."""
        self._mesh.position = (pose[0], pose[1], pose[2])
        self._mesh.wxyz = (pose[6], pose[3], pose[4], pose[5])
        if tuple(self._mesh.color) != rgb:
            self._mesh.color = rgb

    def remove(self) -> None:
        """Take it out of the scene."""
        self._mesh.remove()


@lru_cache(maxsize=8)
def _hand_from_tip(robot: RobotDescription) -> DrawnSurface:
    """Return the open hand in the frame of its tip."""
    urdf = read_urdf(robot.urdf)
    poses = link_poses(urdf, dict.fromkeys(robot.gripper_joints, robot.gripper_open))
    shown = [link for link in urdf.links if link.name in (robot.hand_link, *robot.finger_links)]
    return merged_surface(
        (drawn_surface(shape, 1.0), relative(poses[link.name], poses[robot.tip_frame]))
        for link in shown
        for shape in link.visuals
        if shape.kind
    )
