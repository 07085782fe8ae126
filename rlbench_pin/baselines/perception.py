"""Point clouds from cameras: object models, clusters, obstacles and registration."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray
from rlbench_pin.tasks import COLORS
from rlbench_pin.urdf import UrdfLink, kinematic_urdf, read_urdf


def arm_surface(arm: RobotModel, q: FloatArray, fingers: FloatArray) -> FloatArray:
    """Return points (m, 3) on the surface of arm and gripper at joint positions `q` (n,) [rad] and `fingers` (2,) [m]."""
    names = (*arm.description.arm_joints, *arm.fingers.joints)
    joints = dict(zip(names, [*q.tolist(), *arm.fingers.joint_values(fingers).tolist()], strict=True))
    model = KnownModel.load(arm.description.urdf)
    return model.points_at(joints) @ arm.base.rotation.T + arm.base.translation


PALETTE = {color.name: np.array(color.rgb) for color in COLORS}
"""Colour words and their red, green, blue from 0 to 1."""
BRIGHT = 75.0
"""Percentile of brightness above which points are compared, to select lit points."""


def lit_color(colors: FloatArray) -> FloatArray:
    """Return the colour (3,) of the brighter points of a surface (n, 3)."""
    brightness = colors.sum(axis=1)
    bright = colors[brightness >= np.percentile(brightness, BRIGHT)]
    color: FloatArray = np.median(bright, axis=0)
    return color


def distances(colors: FloatArray, name: str) -> FloatArray:
    """Return the distances of colours (..., 3) from a named one; brightness has less weight than hue."""
    wanted = PALETTE[name]
    brightest = colors.max(axis=-1)
    hue = colors / np.maximum(brightest, 0.08)[..., None] - wanted / max(float(wanted.max()), 0.08)
    weight = np.minimum(1.0, np.maximum(brightest, wanted.max()))
    far: FloatArray = np.linalg.norm(hue, axis=-1) * weight + np.abs(brightest - wanted.max())
    return far


SPACING = 0.006
"""Mean distance of points on a surface [m]."""
MAX_POINTS = 6000
"""Maximum number of points of one link."""
NO_JOINTS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Axis:
    """Axis of a joint in the frame of the model."""

    origin: FloatArray
    """A point on the axis (3,) [m]."""
    direction: FloatArray
    """Unit vector (3,): rotation axis of a hinge, direction of a slide."""


@dataclass(frozen=True, eq=False)
class KnownModel:
    """Kinematics and surface of an object."""

    kinematics: pin.Model
    """Its joints."""
    surfaces: Mapping[str, FloatArray]
    """Link -> points on its visible surface, in the frame of the link (n, 3) [m]."""

    @classmethod
    def named(cls, name: str) -> KnownModel:
        """Return the model of `objects/<name>.urdf` of the package, `chest/chest` for example."""
        return cls.load(asset_path(f"objects/{name}.urdf"))

    @classmethod
    def load(cls, urdf: Path) -> KnownModel:
        """Return the model of a URDF file; read once."""
        return _load(urdf)

    def points_at(self, joints: Mapping[str, float] = NO_JOINTS) -> FloatArray:
        """Return the surface of all links at joint values (default 0) in the frame of the model (n, 3) [m]."""
        return np.concatenate([self.link_points(link, joints) for link in self.surfaces])

    def link_points(self, link: str, joints: Mapping[str, float] = NO_JOINTS) -> FloatArray:
        """Return the surface of one link in the frame of the model (n, 3) [m]."""
        placement = self.placement(link, joints)
        return self.surfaces[link] @ placement.rotation.T + placement.translation

    def placement(self, link: str, joints: Mapping[str, float] = NO_JOINTS) -> pin.SE3:
        """Return the frame of a link in that of the model."""
        data = self.kinematics.createData()
        pin.framesForwardKinematics(self.kinematics, data, self._configuration(joints))
        return data.oMf[self.kinematics.getFrameId(link)].copy()

    def axis(self, joint: str, joints: Mapping[str, float] = NO_JOINTS) -> Axis:
        """Return the axis of a joint."""
        data, number = self.kinematics.createData(), self.kinematics.getJointId(joint)
        q = self._configuration(joints)
        pin.computeJointJacobians(self.kinematics, data, q)
        column = pin.getJointJacobian(self.kinematics, data, number, pin.LOCAL_WORLD_ALIGNED)
        moving = np.reshape(column, (6, -1))[:, self.kinematics.joints[number].idx_v]
        turning = moving[3:] if np.linalg.norm(moving[3:]) > 0.5 else moving[:3]
        return Axis(data.oMi[number].translation.copy(), turning.copy())

    def _configuration(self, joints: Mapping[str, float]) -> FloatArray:
        """Return the configuration of the kinematic model for joint values; the others are 0."""
        q = pin.neutral(self.kinematics)
        for name, value in joints.items():
            q[self.kinematics.joints[self.kinematics.getJointId(name)].idx_q] = value
        return q


@cache
def _load(urdf: Path) -> KnownModel:
    surfaces = {link.name: points for link in read_urdf(urdf).links if len(points := _sampled(link))}
    return KnownModel(pin.buildModelFromXML(kinematic_urdf(urdf)), MappingProxyType(surfaces))


def _sampled(link: UrdfLink) -> FloatArray:
    """Return random points on the visuals of a link, uniform over their area; each call returns the same points."""
    rng = np.random.default_rng(0)
    corners = [shape_surface(shape) for shape in link.visuals]
    if not corners:
        return np.zeros((0, 3))
    triangles = np.concatenate([points[numbers] for points, numbers in corners])
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = 0.5 * np.linalg.norm(across, axis=1)
    count = int(min(MAX_POINTS, max(40.0, areas.sum() / SPACING**2)))
    chosen = triangles[rng.choice(len(triangles), size=count, p=areas / areas.sum())]
    a, b = rng.random((2, count, 1))
    flip = a + b > 1.0
    a, b = np.where(flip, 1.0 - a, a), np.where(flip, 1.0 - b, b)
    points: FloatArray = chosen[:, 0] + a * (chosen[:, 1] - chosen[:, 0]) + b * (chosen[:, 2] - chosen[:, 0])
    return points


CAMERAS = ("left_shoulder", "right_shoulder", "overhead", "wrist", "front")
"""Names of the cameras whose images are used."""
LOWEST, HIGHEST = np.array([-0.1, -0.85, -0.003]), np.array([1.1, 0.85, 0.9])
"""Corners of the box over the table in which objects are detected; heights are relative to the table [m]."""
FLAT = 0.003
"""Height below which points belong to the plane of the table [m]."""
OWN = 0.03
"""Distance from the surface of the arm below which points belong to the arm [m]."""
VOXEL = 0.003
"""Edge of the cubic cells of which each keeps one point [m]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Coloured points in the world."""

    points: FloatArray
    """Shape (n, 3) [m]."""
    colors: FloatArray
    """Red, green, blue from 0 to 1, shape (n, 3)."""

    def __len__(self) -> int:
        return len(self.points)

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Cloud:
        """Return the points that a mask (n,) or indices select."""
        return Cloud(self.points[chosen], self.colors[chosen])

    def between(self, low: float, high: float) -> Cloud:
        """Return the points between two heights over the table [m]."""
        height = self.points[:, 2] - TABLE_HEIGHT
        return self.where((height >= low) & (height < high))

    @property
    def middle(self) -> FloatArray:
        """Middle of the axis-aligned box around the points (3,) [m]."""
        middle: FloatArray = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
        return middle

    @property
    def size(self) -> FloatArray:
        """Sides of that box (3,) [m]."""
        return np.ptp(self.points, axis=0)


@dataclass(frozen=True, eq=False)
class View:
    """The points of one observation, segmented."""

    objects: Cloud
    """Points of objects on or above the table."""
    marks: Cloud
    """Points of the table plane, including markings."""


def back_project(depth: FloatArray, intrinsics: FloatArray, extrinsics: FloatArray) -> FloatArray:
    """Return the world coordinates of every pixel, shape (h * w, 3) [m]; pixel (u, v) is the ray through (u, v).

    Args:
        depth: Depth along the optical axis (h, w) [m].
        intrinsics: Matrix from camera to pixel coordinates (3, 3).
        extrinsics: Matrix from camera to world coordinates (4, 4).
    """
    height, width = depth.shape
    v, u = np.mgrid[0:height, 0:width].astype(float)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ np.linalg.inv(intrinsics).T
    points: FloatArray = (rays * depth.reshape(-1, 1)) @ extrinsics[:3, :3].T + extrinsics[:3, 3]
    return points


def look(observation: Observation, arm: RobotModel) -> View:
    """Return the merged points of the cameras of an observation, segmented.

    Args:
        observation: Colours and depth [m] of cameras, joint positions, and the positions of the fingers.
        arm: Model of the arm, to remove its points.
    """
    clouds = [cloud for name in CAMERAS if (cloud := _seen_by(observation, name)) is not None]
    merged = thinned(Cloud(np.concatenate([c.points for c in clouds]), np.concatenate([c.colors for c in clouds])))
    own = arm_surface(arm, np.asarray(observation.joint_positions), np.asarray(observation.gripper_joint_positions))
    height = merged.points[:, 2] - TABLE_HEIGHT
    apart = cKDTree(own).query(merged.points, distance_upper_bound=OWN)[0] > OWN
    return View(merged.where(apart & (height > FLAT)), merged.where(apart & (height <= FLAT)))


def first_of_cells(points: FloatArray, side: float) -> NDArray[np.int64]:
    """Return the rows of the points (n, 3) that are the first in their cell of a grid, in the order of the cells.

    Args:
        points: [m].
        side: Edge of the cubic cells [m].
    """
    cells = np.floor(points / side).astype(np.int64)
    cells -= cells.min(axis=0, initial=0)
    return np.unique(np.ravel_multi_index(tuple(cells.T), cells.max(axis=0, initial=0) + 1), return_index=True)[1]


def thinned(cloud: Cloud, voxel: float = VOXEL) -> Cloud:
    """Keep one point of each cube of side `voxel` [m]."""
    return cloud.where(np.sort(first_of_cells(cloud.points, voxel)))


def camera_points(observation: Observation, cameras: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return the point clouds of cameras, merged: points, float32 (n, 3) [m], and colours, uint8 (n, 3).

    Raises:
        DatasetError: A camera lacks colours or points.
    """
    pairs = [(getattr(observation, f"{c}_point_cloud", None), getattr(observation, f"{c}_rgb", None)) for c in cameras]
    if any(p is None or c is None for p, c in pairs):
        raise DatasetError(
            f"An observation lacks colours or point clouds of one of {list(cameras)}. Record them, or select other cameras."
        )
    points = np.concatenate([np.asarray(p, dtype=np.float32).reshape(-1, 3) for p, _ in pairs])
    return points, np.concatenate([np.asarray(c, dtype=np.uint8).reshape(-1, 3) for _, c in pairs])


def _seen_by(observation: Observation, name: str) -> Cloud | None:
    """Return the points of one camera in the box over the table; None if it is disabled."""
    depth, rgb = getattr(observation, f"{name}_depth", None), getattr(observation, f"{name}_rgb", None)
    if depth is None or rgb is None:
        return None
    misc = observation.misc
    points = back_project(depth, misc[f"{name}_camera_intrinsics"], misc[f"{name}_camera_extrinsics"])
    local = points - (0.0, 0.0, TABLE_HEIGHT)
    inside = ((local > LOWEST) & (local < HIGHEST)).all(axis=1)
    return Cloud(points[inside], rgb.reshape(-1, 3)[inside] / 255.0)


GAP = 0.012
"""Distance below which points belong to one cluster [m]."""
FEWEST_POINTS = 25
"""Minimum number of points of a cluster."""


def clusters(cloud: Cloud, gap: float = GAP, fewest: int = FEWEST_POINTS) -> list[Cloud]:
    """Return the connected parts of a cloud, the largest first."""
    if len(cloud) == 0:
        return []
    pairs = cKDTree(cloud.points).query_pairs(gap, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(cloud), len(cloud)))
    _, labels = connected_components(links, directed=False)
    sizes = np.bincount(labels)
    order = [label for label in np.argsort(-sizes, kind="stable") if sizes[label] >= fewest]
    return [cloud.where(labels == label) for label in order]


def rectangle(points: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """Return middle (2,) [m], yaw [rad] and sides (2,) [m] of the smallest upright rectangle around points (n, 2 or 3)."""
    flat, best = points[:, :2], (np.inf, 0.0)
    for yaw in np.linspace(0.0, np.pi / 2.0, 90, endpoint=False):
        sides = np.ptp(flat @ _turn(yaw), axis=0)
        best = min(best, (float(sides[0] * sides[1]), float(yaw)))
    turned = flat @ _turn(best[1])
    low, high = turned.min(axis=0), turned.max(axis=0)
    return _turn(best[1]) @ (0.5 * (low + high)), best[1], high - low


def _turn(yaw: float) -> FloatArray:
    """Return the rotation matrix (2, 2) of `yaw` [rad]."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])


HEADINGS = 16
"""Number of yaw angles from which the registration starts."""
FARTHEST = 0.03
"""Upper bound of distances in a fit [m]."""
POINTS = 1200
"""Number of scene points in the registration."""
SURFACE = 12000
"""Number of model points in the registration; with fewer, neighbours are on different faces and normals are wrong."""
STAGES = (0.12, 0.04, 0.015)
"""Maximum correspondence distance of each stage of the registration [m]."""
UNSEEN = 0.3
"""Weight of the distances from model to scene, which are larger where the model is hidden; the other direction has the rest."""


@dataclass(frozen=True, eq=False)
class Located:
    """A detected model in the scene."""

    model: KnownModel
    """The model."""
    placement: pin.SE3
    """Its frame in the world."""
    joints: Mapping[str, float]
    """Values of its joints."""
    error: float
    """Weighted mean distance of scene and model [m]; each distance is clipped to `FARTHEST`."""

    def point(self, local: FloatArray) -> FloatArray:
        """Return the world coordinates (3,) [m] of a point in the frame of the model."""
        point: FloatArray = self.placement.act(np.asarray(local, dtype=float))
        return point

    def link_points(self, link: str) -> FloatArray:
        """Return the surface of a link in the world (n, 3) [m]."""
        points: FloatArray = self.model.link_points(link, self.joints) @ self.placement.rotation.T + self.placement.translation
        return points


def locate(model: KnownModel, cloud: Cloud, states: Iterable[Mapping[str, float]] = (NO_JOINTS,)) -> Located:
    """Return the pose of an upright model on the table.

    Args:
        model: The model.
        cloud: Points of the object only.
        states: Joint values to try.
    """
    scene = thinned(cloud, 0.006).points
    scene = scene[:: max(1, len(scene) // POINTS)]
    found = [_best(model, joints, scene) for joints in states]
    return min(found, key=lambda located: located.error)


def _best(model: KnownModel, joints: Mapping[str, float], scene: FloatArray) -> Located:
    """Return the best registration of the model with given joint values."""
    import small_gicp  # part of the extra `classical`; the other baselines work without it

    surface = outside(model.points_at(joints))
    surface = surface[:: max(1, len(surface) // SURFACE)]
    target, tree = small_gicp.PointCloud(surface), cKDTree(surface)
    points = small_gicp.PointCloud(scene)
    small_gicp.estimate_normals(target, num_neighbors=12)
    gicp_tree, scene_tree = small_gicp.KdTree(target), cKDTree(scene)
    fits: list[tuple[float, int, pin.SE3]] = []
    for yaw in np.linspace(-np.pi, np.pi, HEADINGS, endpoint=False):
        placement = _centred(surface, scene, float(yaw))
        for farthest in STAGES:
            result = small_gicp.align(
                target, points, gicp_tree, placement.inverse().homogeneous,
                registration_type="PLANE_ICP", max_correspondence_distance=farthest, max_iterations=15,
            )  # fmt: skip
            placement = _upright(pin.SE3(result.T_target_source).inverse())
        fits.append((_misfit(tree, scene_tree, surface, scene, placement), len(fits), placement))
    error, _, placement = min(fits)
    return Located(model, placement, dict(joints), error)


def outside(points: FloatArray, cell: float = 0.02, depth: float = 0.01) -> FloatArray:
    """Return the points (m, 3) of a surface that are visible from above or from a side; inner points are removed.

    Args:
        points: Points on the surface (n, 3) [m].
        cell: Edge of the cells across the viewing direction; the nearest point of a cell hides the others [m].
        depth: Points less than this behind the nearest point stay visible [m].
    """
    seen = np.zeros(len(points), dtype=bool)
    for slope in (0.3, 0.8, 1.5):
        for yaw in np.linspace(-np.pi, np.pi, 8, endpoint=False):
            along = points @ pin.rpy.rpyToMatrix(0.0, slope, yaw)  # x towards the object, and down
            cells = np.floor(along[:, 1:] / cell).astype(np.int64)
            _, which = np.unique(cells[:, 0] * 100_000 + cells[:, 1], return_inverse=True)
            nearest = np.full(which.max() + 1, np.inf)
            np.minimum.at(nearest, which, along[:, 0])
            seen |= along[:, 0] < nearest[which] + depth
    return points[seen]


def _centred(surface: FloatArray, scene: FloatArray, yaw: float) -> pin.SE3:
    """Return the placement on the table with a yaw [rad] that aligns the centres of the boxes around model and scene."""
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
    turned = surface @ turn.T
    shift = 0.5 * (scene.min(axis=0) + scene.max(axis=0)) - 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    return pin.SE3(turn, np.array([shift[0], shift[1], TABLE_HEIGHT]))


def _upright(placement: pin.SE3) -> pin.SE3:
    """Return the placement with only its yaw and its x and y, upright on the table."""
    yaw = float(np.arctan2(placement.rotation[1, 0], placement.rotation[0, 0]))
    return pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), np.array([*placement.translation[:2], TABLE_HEIGHT]))


def _misfit(tree: cKDTree, scene_tree: cKDTree, surface: FloatArray, scene: FloatArray, placement: pin.SE3) -> float:
    """Return the weighted mean distance between scene and model [m], in both directions."""
    local = (scene - placement.translation) @ placement.rotation
    there = surface @ placement.rotation.T + placement.translation
    seen = np.minimum(tree.query(local)[0], FARTHEST).mean()
    hidden = np.minimum(scene_tree.query(there[:: max(1, len(there) // POINTS)])[0], FARTHEST).mean()
    return float((1.0 - UNSEEN) * seen + UNSEEN * hidden)


TABLE = ((1.6, 2.0, 0.1), (0.3, 0.0, TABLE_HEIGHT - 0.05))
"""Size and centre of the table [m]."""


def near(world: WorldSnapshot, point: FloatArray, within: float) -> list[str]:
    """Return the names of the boxes that are nearer than `within` [m] to a point (3,) [m]; the table is left out."""
    names = []
    for body in world.bodies:
        apart = np.abs(point - body.link_poses[0, :3]) - 0.5 * np.array(body.shapes[0].size)
        if not body.in_room and np.linalg.norm(np.maximum(apart, 0.0)) < within:
            names.append(body.name)
    return names
