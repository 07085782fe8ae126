"""3D models of room, arm and bodies in the browser, with the meshes and colours of the simulation."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from viser import FrameHandle, MeshHandle, SceneApi, SceneNodeHandle

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import DEFAULT_ROBOT, RobotDescription, robot_description
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.scene.snapshot import ROOM
from rlbench_pin.sim.render.raster.meshes import creased_normals
from rlbench_pin.sim.room import Quad, read_quads
from rlbench_pin.spatial import FloatArray, PoseLike, compose, pose_to_matrix, relative
from rlbench_pin.urdf import UrdfLink, UrdfShape, read_urdf
from rlbench_pin.values import as_pose
from rlbench_pin.viewer.places import link_poses, places_at_rest

_DIGITS = 6
_UNLIT = "KHR_materials_unlit"
_ONE_LEVEL, _LINEAR, _REPEAT = 9985, 9729, 10497
"""LINEAR_MIPMAP_NEAREST, LINEAR and REPEAT of OpenGL: the renderer reads one level of a texture instead of two."""


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """A surface in the frame of its link."""

    corners: NDArray[np.float32]
    """Vertices (n, 3) [m]."""
    triangles: NDArray[np.uint32]
    """Vertex indices (m, 3)."""


def drawn_surface(shape: UrdfShape, scale: float) -> DrawnSurface:
    """Return the surface of a visual, scaled by `scale`; a mesh file is read again after a change.

    Raises:
        AssetNotFound: The mesh file does not exist.
        AssetInvalid: The file is not a mesh.
    """
    written = shape.mesh.stat().st_mtime_ns if shape.mesh is not None and shape.mesh.is_file() else 0
    return _drawn_surface(shape, scale, written)


@lru_cache(maxsize=1024)
def _drawn_surface(shape: UrdfShape, scale: float, written: int) -> DrawnSurface:
    points, numbers = shape_surface(shape, scale)
    corners = points[numbers]
    normals = creased_normals(corners)
    # Browsers average the normals of faces that share a vertex: merge only vertices with the same position and normal.
    both = np.concatenate([corners.reshape(-1, 3), normals.reshape(-1, 3)], axis=1).round(_DIGITS)
    unique, index = np.unique(both, axis=0, return_inverse=True)
    return DrawnSurface(unique[:, :3].astype(np.float32), index.reshape(-1, 3).astype(np.uint32))


@lru_cache(maxsize=16)
def room_glb(urdfs: tuple[Path, ...], *, lit: bool) -> bytes:
    """Return parts of the room as a GLB file with the textures of the simulation, visible from inside only.

    Quads with the same texture and colour are one mesh: without a GPU each mesh takes a third of a millisecond for any size.

    Args:
        urdfs: Model files of the parts.
        lit: Draw lights and shadows on the parts; large surfaces are faster without.
    """
    alike: dict[tuple[object, ...], list[Quad]] = {}
    for quad in (quad for urdf in urdfs for quad in read_quads(urdf)):
        alike.setdefault((quad.texture, quad.color), []).append(quad)
    glb: bytes = trimesh.Scene([_quads_mesh(quads) for quads in alike.values()]).export(file_type="glb")
    return glb if lit else _unlit(glb)


def _unlit(glb: bytes) -> bytes:
    """Return a GLB file with materials that ignore lights, and with fast texture filters."""
    size = int.from_bytes(glb[12:16], "little")
    said = json.loads(glb[20 : 20 + size])
    for material in said["materials"]:
        material["extensions"] = {_UNLIT: {}}
    said["extensionsUsed"] = [_UNLIT]
    said["samplers"] = [{"minFilter": _ONE_LEVEL, "magFilter": _LINEAR, "wrapS": _REPEAT, "wrapT": _REPEAT}]
    for texture in said.get("textures", ()):
        texture["sampler"] = 0
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + size :]
    return (
        glb[:8] + (20 + len(text) + len(rest)).to_bytes(4, "little") + len(text).to_bytes(4, "little") + glb[16:20] + text + rest
    )


def _quads_mesh(quads: Sequence[Quad]) -> trimesh.Trimesh:
    """Return the mesh of quads of one colour and one texture."""
    first = quads[0]
    color = np.array([*(round(255 * share) for share in first.color), 255], dtype=np.uint8)
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=color, metallicFactor=0.0, roughnessFactor=0.9)
    if first.texture is not None:
        material.baseColorTexture = Image.open(first.texture).convert("RGB")
    corners = np.concatenate([_four(quad.corner, *quad.edges) for quad in quads])
    uv = np.concatenate([np.zeros((4, 2)) if quad.uv is None else _four(*quad.uv) for quad in quads])
    triangles = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * number for number in range(len(quads))])
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(corners, triangles, visual=visual, process=False)


def _four(corner: NDArray[np.float64], along: NDArray[np.float64], up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners (4, k) of a parallelogram with a corner (k,) and edges (k,)."""
    return np.array([corner, corner + along, corner + along + up, corner + up])


def merged_surface(parts: Iterable[tuple[DrawnSurface, FloatArray]]) -> DrawnSurface:
    """Return one surface that contains several surfaces.

    Args:
        parts: Surfaces with the pose (7,) of their frame in the frame of the result.
    """
    corners, triangles, count = list[NDArray[np.float32]](), list[NDArray[np.uint32]](), 0
    for surface, pose in parts:
        matrix = pose_to_matrix(pose)
        corners.append((surface.corners @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32))
        triangles.append(surface.triangles + np.uint32(count))
        count += len(surface.corners)
    return DrawnSurface(np.concatenate(corners), np.concatenate(triangles))


Rgb = tuple[int, int, int]
"""Red, green, blue from 0 to 255."""
OnPick = Callable[[str], None]
"""Called with the name of the element that was clicked."""
_UNCOLORED = (1.0, 1.0, 1.0, 1.0)
_GHOST_OPACITY = 0.45


class ModelFigure:
    """The links of one model, drawn separately.

    Args:
        scene: Scene of the page.
        path: Name of the node, such as `/bodies/cup`.
        urdf: Model file.
        color: Red, green, blue and optionally opacity from 0 to 1 of all visuals; None uses those of the file.
        scale: Factor for the lengths.
        picked: Argument of `on_pick`, in which `{link}` is replaced by the name of the link.
        on_pick: Function that is called after a click on a link.

    Raises:
        AssetNotFound: The file or one of its meshes does not exist.
        AssetInvalid: The file or one of its meshes cannot be read.
    """

    def __init__(
        self,
        scene: SceneApi,
        path: str,
        urdf: Path,
        color: Sequence[float] | None = None,
        scale: float = 1.0,
        picked: str = "{link}",
        on_pick: OnPick | None = None,
    ) -> None:
        self._scene, self._color, self._on_pick = scene, color, on_pick
        links = read_urdf(urdf).links
        surfaces = {link.name: tuple(drawn_surface(s, scale) for s in link.visuals if s.kind) for link in links}
        self._top = scene.add_frame(path, show_axes=False)
        self._frames: dict[str, FrameHandle] = {}
        self._parts: dict[str, list[tuple[MeshHandle, Rgb]]] = {}
        self._episode_colors: dict[str, Rgb] = {}
        for number, link in enumerate(links):
            node = f"{path}/{number}"
            self._frames[link.name] = scene.add_frame(node, show_axes=False)
            self._parts[link.name] = self._draw(node, link, surfaces[link.name], picked.replace("{link}", link.name))

    def _draw(self, node: str, link: UrdfLink, surfaces: tuple[DrawnSurface, ...], picked: str) -> list[tuple[MeshHandle, Rgb]]:
        """Draw the visuals of a link, and return each mesh with its own colour."""
        parts = []
        colors = [shape.color for shape in link.visuals if shape.kind]
        for number, (surface, own) in enumerate(zip(surfaces, colors, strict=True)):
            red, green, blue, alpha = (*(self._color or own or _UNCOLORED), 1.0)[:4]
            rgb = (round(255 * red), round(255 * green), round(255 * blue))
            part = self._scene.add_mesh_simple(
                f"{node}/{number}",
                surface.corners,
                surface.triangles,
                color=rgb,
                opacity=None if alpha >= 1.0 else alpha,
                side="double" if alpha < 1.0 else "front",
                cast_shadow=alpha >= 1.0,
            )
            if (on_pick := self._on_pick) is not None:
                part.on_click(lambda _: on_pick(picked))
            parts.append((part, rgb))
        return parts

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links that are drawn."""
        return tuple(self._frames)

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        """Move links to world poses (7,) by name; links that are not drawn are ignored."""
        for link, pose in poses.items():
            if (frame := self._frames.get(link)) is not None:
                move_node(frame, pose)

    def paint(self, link: str, rgb: Rgb | None) -> None:
        """Show a link in one colour; None restores its own colours."""
        for part, own in self._parts.get(link, ()):
            color = self._episode_colors.get(link, own) if rgb is None else rgb
            if tuple(part.color) != color:
                part.color = color

    def set_color(self, link: str, rgb: Rgb | None) -> None:
        """Set the own colour of a link, which `paint(link, None)` shows; None restores the initial colours."""
        if rgb != self._episode_colors.get(link):
            self._episode_colors.pop(link, None)
            if rgb is not None:
                self._episode_colors[link] = rgb
            self.paint(link, None)

    def show(self, visible: bool) -> None:
        """Show or hide the model."""
        self._top.visible = visible

    def remove(self) -> None:
        """Remove the model from the scene."""
        self._top.remove()


_Drawn = tuple[str, int, BodySpec]


class Figures:
    """Draws scenes in a page, and moves the drawn bodies.

    Args:
        scene: Scene of a server or of one of its clients.
        robot: The robot; None is the default robot.
        on_pick: Function that is called after a click, with `<body>/<link>` or the name of a ghost.
    """

    def __init__(self, scene: SceneApi, robot: RobotDescription | None = None, on_pick: OnPick | None = None) -> None:
        self._scene, self._on_pick = scene, on_pick
        self._robot = robot or robot_description(DEFAULT_ROBOT)
        self._urdf = read_urdf(self._robot.urdf)
        self._bodies: dict[str, tuple[_Drawn, ModelFigure]] = {}
        self._ghosts: dict[str, MeshHandle] = {}
        self._marked: set[str] = set()
        self._mark: Rgb = (230, 40, 40)
        self._light_up()
        self._arm = ModelFigure(scene, "/arm", self._robot.urdf)
        self.arm(self._robot.home, [self._robot.gripper_open] * len(self._robot.gripper_joints))

    def _light_up(self) -> None:
        """Create the lights and the room."""
        self._scene.set_up_direction("+z")
        self._scene.configure_environment_map(None)  # the slowest part of a frame without a GPU
        self._scene.add_light_ambient("/lights/ambient", intensity=1.3)
        self._draw_room("around", ROOM[1:], lit=False)
        self.shadows(True)

    def _draw_room(self, node: str, parts: Sequence[str], lit: bool) -> None:
        glb = room_glb(tuple(asset_path(f"room/{part}.urdf") for part in parts), lit=lit)
        self._scene.add_glb(f"/room/{node}", glb, cast_shadow=False, receive_shadow=lit)

    def shadows(self, cast: bool) -> None:
        """Switch shadows on the table on or off; without a GPU a frame takes 1.5 times as long with them."""
        self._scene.configure_default_lights(cast_shadow=cast)
        self._draw_room(ROOM[0], ROOM[:1], lit=cast)

    # Bodies ----------------------------------------------------------------------------------------------------------

    def show(self, spec: SceneSpec) -> dict[str, str]:
        """Draw the bodies of a scene at their initial poses; bodies that are already drawn are reused.

        Returns:
            Body -> reason why it cannot be drawn, as text.
        """
        wanted = {body.name: self._drawn(spec, body) for body in spec.body}
        for name in [name for name, (drawn, _) in self._bodies.items() if wanted.get(name) != drawn]:
            self._bodies.pop(name)[1].remove()
        faults = {}
        for body in spec.body:
            if body.name not in self._bodies:
                try:
                    file, picked = resolve_asset(spec, body.asset), f"{body.name}/{{link}}"
                    figure = ModelFigure(self._scene, f"/bodies/{body.name}", file, body.color, body.scale, picked, self._on_pick)
                    self._bodies[body.name] = (wanted[body.name], figure)
                except RlbenchPinError as error:
                    faults[body.name] = str(error)
        self.present(self._bodies)
        self.paint({})
        self.move(places_at_rest(spec).links)
        return faults

    def _drawn(self, spec: SceneSpec, body: BodySpec) -> _Drawn:
        """Return all values that the drawing of a body depends on, except its pose."""
        file = resolve_asset(spec, body.asset)
        written = file.stat().st_mtime_ns if file.is_file() else 0
        return str(file), written, BodySpec(name=body.name, asset=body.asset, color=body.color, scale=body.scale)

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        """Move links to world poses (7,) by `<body>/<link>`; bodies that are not drawn are ignored."""
        by_body: dict[str, dict[str, FloatArray]] = {}
        for name, pose in poses.items():
            body, _, link = name.partition("/")
            by_body.setdefault(body, {})[link] = pose
        for body, links in by_body.items():
            if body in self._bodies:
                self._bodies[body][1].move(links)

    # Episodes --------------------------------------------------------------------------------------------------------

    def present(self, bodies: Collection[str]) -> None:
        """Show these bodies and hide all others."""
        for name, (_, figure) in self._bodies.items():
            figure.show(name in bodies)

    def paint(self, colors: Mapping[str, Sequence[float]]) -> None:
        """Show links, by `<body>/<link>`, in colours (3 or 4,) from 0 to 1; other links have their initial colours."""
        for name, (_, figure) in self._bodies.items():
            for link in figure.links:
                color = colors.get(f"{name}/{link}")
                figure.set_color(link, None if color is None else _rgb(color))
        self._paint_marked()

    # Arm -------------------------------------------------------------------------------------------------------------

    def arm(self, q: Sequence[float] | FloatArray, fingers: Sequence[float] | FloatArray) -> None:
        """Show the arm at joint positions (n,) [rad] and finger positions (m,) [m]."""
        grip = fingers_of(self._robot)
        values = (*map(float, q), *grip.joint_values(np.asarray(fingers, dtype=float)).tolist())
        positions = dict(zip((*self._robot.arm_joints, *grip.joints), values, strict=True))
        base = np.array(self._robot.base_pose)
        self._arm.move({link: compose(base, pose) for link, pose in link_poses(self._urdf, positions).items()})

    def mark(self, names: Iterable[str], rgb: Rgb = (230, 40, 40)) -> None:
        """Show links in one colour, and restore the colours of previously marked links.

        Args:
            names: `<body>/<link>`, `<body>` for all its links, or a link of the arm, with or without the name of the arm.
            rgb: The colour, from 0 to 255.
        """
        self._paint_marked(restore=True)
        self._marked = set(names)
        self._mark = rgb
        self._paint_marked()

    def _paint_marked(self, restore: bool = False) -> None:
        """Show the marked links in the colour of marks, or with `restore` in their own colours."""
        for name in self._marked:
            owner, _, link = name.partition("/")
            figure = self._bodies[owner][1] if owner in self._bodies else self._arm
            links = (link,) if link else (figure.links if owner in self._bodies else (owner,))
            for each in links:
                figure.paint(each, None if restore else self._mark)

    # Ghosts ----------------------------------------------------------------------------------------------------------

    def ghost(self, name: str, pose: PoseLike, rgb: Rgb) -> None:
        """Show a ghost: the open gripper, translucent, with its tip at a world pose (7,). An existing ghost moves there.

        Args:
            name: Name of the ghost, such as that of a waypoint.
            pose: Pose (7,) of the tip in the world.
            rgb: The colour, from 0 to 255.
        """
        tip = as_pose(pose, "pose of a ghost")
        if (mesh := self._ghosts.get(name)) is None:
            surface = _gripper_surface(self._robot)
            mesh = self._ghosts[name] = self._scene.add_mesh_simple(
                f"/ghosts/{name}", surface.corners, surface.triangles, color=rgb, opacity=_GHOST_OPACITY, cast_shadow=False
            )
            if (on_pick := self._on_pick) is not None:
                mesh.on_click(lambda _: on_pick(name))
        move_node(mesh, tip)
        if tuple(mesh.color) != rgb:
            mesh.color = rgb

    def remove_ghost(self, name: str) -> None:
        """Remove a ghost, if it exists."""
        if (found := self._ghosts.pop(name, None)) is not None:
            found.remove()

    @property
    def ghosts(self) -> tuple[str, ...]:
        """Names of the ghosts."""
        return tuple(self._ghosts)


def _rgb(color: Sequence[float]) -> Rgb:
    """Convert a colour from 0 to 1 to a colour from 0 to 255, without opacity."""
    red, green, blue = (round(255 * share) for share in color[:3])
    return red, green, blue


@lru_cache(maxsize=8)
def _gripper_surface(robot: RobotDescription) -> DrawnSurface:
    """Return the surface of the open gripper in the frame of the tip."""
    urdf = read_urdf(robot.urdf)
    grip = fingers_of(robot)
    opened = grip.joint_values(np.full(len(grip.drives), robot.gripper_open))
    poses = link_poses(urdf, dict(zip(grip.joints, opened.tolist(), strict=True)))
    shown = [link for link in urdf.links if link.name in grip.links]
    return merged_surface(
        (drawn_surface(shape, 1.0), relative(poses[link.name], poses[robot.tip_frame]))
        for link in shown
        for shape in link.visuals
        if shape.kind
    )


def move_node(node: SceneNodeHandle, pose: FloatArray) -> None:
    """Move a node of the page to a pose (7,)."""
    node.position = (pose[0], pose[1], pose[2])
    node.wxyz = (pose[6], pose[3], pose[4], pose[5])
