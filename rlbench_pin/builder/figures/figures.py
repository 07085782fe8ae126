"""What a scene looks like in the browser: room, arm and bodies, as in simulation."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
from viser import SceneApi

from rlbench_pin.assets import asset_path
from rlbench_pin.builder.figures.chain import link_poses
from rlbench_pin.builder.figures.hand_ghost import HandGhost
from rlbench_pin.builder.figures.model_figure import Look, ModelFigure, OnPick, Rgb
from rlbench_pin.builder.figures.places import places_at_rest
from rlbench_pin.builder.figures.surfaces import room_glb
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import DEFAULT_ROBOT, RobotDescription, robot_description
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.scene.snapshot import ROOM
from rlbench_pin.spatial import FloatArray, PoseLike, compose
from rlbench_pin.urdf import read_urdf
from rlbench_pin.values import as_pose

_Drawn = tuple[str, int, BodySpec]


class Figures:
    """Draws scenes into one page, and moves what it has drawn.

    Args:
        scene: Where to draw: that of a server, or of one of its clients.
        robot: The arm; the default one where None.
        on_pick: Called with `<body>/<link>`, or the name of a ghost, when somebody clicks on it.
    """

    def __init__(self, scene: SceneApi, robot: RobotDescription | None = None, on_pick: OnPick | None = None) -> None:
        self._scene, self._on_pick = scene, on_pick
        self._robot = robot or robot_description(DEFAULT_ROBOT)
        self._urdf = read_urdf(self._robot.urdf)
        self._bodies: dict[str, tuple[_Drawn, ModelFigure]] = {}
        self._ghosts: dict[str, HandGhost] = {}
        self._marked: set[str] = set()
        self._mark: Rgb = (230, 40, 40)
        self._light_up()
        self._arm = ModelFigure(scene, "/arm", self._robot.urdf, Look())
        self.arm(self._robot.home, [self._robot.gripper_open] * len(self._robot.gripper_joints))

    def _light_up(self) -> None:
        self._scene.set_up_direction("+z")
        self._scene.configure_environment_map(None)  # costs more than all the rest where there is no graphics card
        self._scene.add_light_ambient("/lights/ambient", intensity=1.3)
        self._draw_room("around", ROOM[1:], lit=False)
        self.shadows(True)

    def _draw_room(self, node: str, parts: Sequence[str], lit: bool) -> None:
        glb = room_glb(tuple(asset_path(f"room/{part}.urdf") for part in parts), lit=lit)
        self._scene.add_glb(f"/room/{node}", glb, cast_shadow=False, receive_shadow=lit)

    def shadows(self, cast: bool) -> None:
        """Let things cast shadows on the table, or not; without a graphics card a picture takes half as long again with them."""
        self._scene.configure_default_lights(cast_shadow=cast)
        self._draw_room(ROOM[0], ROOM[:1], lit=cast)

    # Bodies ----------------------------------------------------------------------------------------------------------

    def show(self, spec: SceneSpec) -> dict[str, str]:
        """Draw the bodies of a scene where they stand at rest; what is drawn already stays.

        Returns:
            Body -> why it cannot be drawn.
        """
        wanted = {body.name: self._drawn(spec, body) for body in spec.body}
        for name in [name for name, (drawn, _) in self._bodies.items() if wanted.get(name) != drawn]:
            self._bodies.pop(name)[1].remove()
        faults = {}
        for body in spec.body:
            if body.name not in self._bodies:
                try:
                    self._bodies[body.name] = (wanted[body.name], self._body_figure(spec, body))
                except RlbenchPinError as error:
                    faults[body.name] = str(error)
        self.present(self._bodies)
        self.paint({})
        self.move(places_at_rest(spec).links)
        return faults

    def _drawn(self, spec: SceneSpec, body: BodySpec) -> _Drawn:
        """Return all that the picture of a body depends on, but its place."""
        file = resolve_asset(spec, body.asset)
        written = file.stat().st_mtime_ns if file.is_file() else 0
        return str(file), written, BodySpec(name=body.name, asset=body.asset, color=body.color, scale=body.scale)

    def _body_figure(self, spec: SceneSpec, body: BodySpec) -> ModelFigure:
        look = Look(body.color, body.scale)
        file = resolve_asset(spec, body.asset)
        return ModelFigure(self._scene, f"/bodies/{body.name}", file, look, f"{body.name}/{{link}}", self._on_pick)

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        """Put links at world poses (7,), by `<body>/<link>`; those of bodies that are not drawn are passed over."""
        by_body: dict[str, dict[str, FloatArray]] = {}
        for name, pose in poses.items():
            body, _, link = name.partition("/")
            by_body.setdefault(body, {})[link] = pose
        for body, links in by_body.items():
            if body in self._bodies:
                self._bodies[body][1].move(links)

    # Episodes --------------------------------------------------------------------------------------------------------

    def present(self, bodies: Collection[str]) -> None:
        """Let these bodies be seen, and no others."""
        for name, (_, figure) in self._bodies.items():
            figure.show(name in bodies)

    def paint(self, colors: Mapping[str, Sequence[float]]) -> None:
        """Show links, by `<body>/<link>`, in colours (3 or 4,) in 0..1 that an episode gives them, all others in their own."""
        for name, (_, figure) in self._bodies.items():
            for link in figure.links:
                color = colors.get(f"{name}/{link}")
                figure.wear(link, None if color is None else _rgb(color))
        self._paint_marked()

    # Arm -------------------------------------------------------------------------------------------------------------

    def arm(self, q: Sequence[float] | FloatArray, fingers: Sequence[float] | FloatArray) -> None:
        """Show the arm at joint positions (n,) [rad], with its fingers at (m,) [m]."""
        names = (*self._robot.arm_joints, *self._robot.gripper_joints)
        positions = dict(zip(names, (*map(float, q), *map(float, fingers)), strict=True))
        base = np.array(self._robot.base_pose)
        self._arm.move({link: compose(base, pose) for link, pose in link_poses(self._urdf, positions).items()})

    def mark(self, names: Iterable[str], rgb: Rgb = (230, 40, 40)) -> None:
        """Show links in one colour, those marked before in their own again.

        Args:
            names: `<body>/<link>`, a whole `<body>`, or a link of the arm, with or without its name before it.
            rgb: The colour.
        """
        self._paint_marked(restore=True)
        self._marked = set(names)
        self._mark = rgb
        self._paint_marked()

    def _paint_marked(self, restore: bool = False) -> None:
        for name in self._marked:
            owner, _, link = name.partition("/")
            figure = self._bodies[owner][1] if owner in self._bodies else self._arm
            links = (link,) if link else (figure.links if owner in self._bodies else (owner,))
            for each in links:
                figure.paint(each, None if restore else self._mark)

    # Ghosts ----------------------------------------------------------------------------------------------------------

    def ghost(self, name: str, pose: PoseLike, rgb: Rgb) -> None:
        """Show the hand alone, open and translucent, with its tip at a world pose (7,); one of the same name moves there.

        Args:
            name: Name of the ghost, such as that of a waypoint.
            pose: Pose (7,) of the tip in the world.
            rgb: Its colour, from 0 to 255.
        """
        tip = as_pose(pose, "pose of a ghost")
        if name not in self._ghosts:
            self._ghosts[name] = HandGhost(self._scene, name, self._robot, rgb, self._on_pick)
        self._ghosts[name].show(tip, rgb)

    def remove_ghost(self, name: str) -> None:
        """Take a ghost away, if there is one of that name."""
        if (found := self._ghosts.pop(name, None)) is not None:
            found.remove()

    @property
    def ghosts(self) -> tuple[str, ...]:
        """Names of the ghosts."""
        return tuple(self._ghosts)


def _rgb(color: Sequence[float]) -> Rgb:
    red, green, blue = (round(255 * share) for share in color[:3])
    return red, green, blue
