"""Where everything of a scene stands before anything falls: the chain of parents, without physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rlbench_pin.builder.figures.chain import link_poses
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec
from rlbench_pin.spatial import IDENTITY, FloatArray, compose, pose_to_se3, se3_to_pose
from rlbench_pin.urdf import read_urdf


@dataclass(frozen=True, eq=False)
class Places:
    """World poses of all that a scene file names."""

    things: Mapping[str, FloatArray]
    """Pose (7,) of `root`, `world` and each body, frame, region, sensor and waypoint, by name."""
    links: Mapping[str, FloatArray]
    """Pose (7,) of each link of each body, by `<body>/<link>`."""
    missing: Mapping[str, str] = field(default_factory=dict)
    """What has no place, by name, and why: a file that cannot be read, a parent that does not exist."""

    def of(self, name: str) -> FloatArray | None:
        """Return the pose (7,) of a thing or of `<body>/<link>`; None for what has none."""
        return self.things.get(name, self.links.get(name))


def places_at_rest(spec: SceneSpec, poses: Mapping[str, FloatArray] | None = None) -> Places:
    """Return where everything stands, with the root at its nominal pose and joints at their start positions.

    Args:
        spec: What the scene file says.
        poses: World poses (7,) that things have been given by hand, by name; their children follow.
    """
    return _Walk(spec, poses or {}).places()


class _Walk:
    def __init__(self, spec: SceneSpec, given: Mapping[str, FloatArray]) -> None:
        self._spec, self._given = spec, given
        root = se3_to_pose(pose_to_se3(spec.placement.pose))
        self._things: dict[str, FloatArray] = {WORLD: IDENTITY.copy(), ROOT: given.get(ROOT, root)}
        self._links: dict[str, FloatArray] = {}
        self._missing: dict[str, str] = {}

    def places(self) -> Places:
        """Place parents before children, as long as there is something to place."""
        waiting: list[PosedSpec] = list(self._spec.posed())
        while True:
            ready = [thing for thing in waiting if self._parent(thing) is not None]
            if not ready:
                break
            for thing in ready:
                self._place(thing)
            waiting = [thing for thing in waiting if thing.name not in self._things]
        for thing in waiting:
            self._missing[thing.name] = f"its parent '{thing.parent}' has no place."
        return Places(self._things, self._links, self._missing)

    def _parent(self, thing: PosedSpec) -> FloatArray | None:
        return self._things.get(thing.parent, self._links.get(thing.parent))

    def _place(self, thing: PosedSpec) -> None:
        parent = self._parent(thing)
        if parent is None:
            return
        pose = self._given.get(thing.name)
        self._things[thing.name] = compose(parent, thing.pose) if pose is None else pose
        if isinstance(thing, BodySpec):
            self._place_links(thing)

    def _place_links(self, body: BodySpec) -> None:
        joints = {j.name.partition("/")[2]: j.position for j in self._spec.joint if j.name.partition("/")[0] == body.name}
        try:
            urdf = read_urdf(resolve_asset(self._spec, body.asset), f"body '{body.name}'")
            poses = link_poses(urdf, joints, body.scale)
        except RlbenchPinError as error:
            self._missing[body.name] = str(error)
            return
        for link, pose in poses.items():
            self._links[f"{body.name}/{link}"] = compose(self._things[body.name], pose)


__all__ = ["Places", "places_at_rest"]
