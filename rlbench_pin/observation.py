"""`Observation` and `Demo`: plain records of arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, fields
from types import MappingProxyType
from typing import Any, Literal, get_args, overload

import numpy as np

from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.values import as_names, as_record, as_several, as_text, as_whole, is_whole

Array = np.ndarray
RandomState = tuple[Any, ...]
"""State of the global numpy generator, from `numpy.random.get_state()`."""

CAMERAS: tuple[str, ...] = ("left_shoulder", "right_shoulder", "overhead", "wrist", "front")
PRODUCTS: tuple[str, ...] = ("rgb", "depth", "mask", "point_cloud")
IN_METRES = "camera_depth_in_meters"
"""End of the `misc` key that a camera with depth in [m] adds."""
LOW_DIM: tuple[str, ...] = (
    "gripper_open",
    "joint_velocities",
    "joint_positions",
    "joint_forces",
    "gripper_pose",
    "gripper_joint_positions",
    "gripper_touch_forces",
    "task_low_dim_state",
)


class OptionalFields:
    """Fields that exist only after an assignment; before, they are None and not in `vars`."""

    ignore_collisions: bool | None = None
    """In demonstrations: whether the segment to this frame was planned without collision checks."""


@dataclass(eq=False)
class Observation(OptionalFields):
    """Observation at one instant; a disabled field is None.

    Images are (h, w, ...) arrays, top row first: rgb uint8, depth float32, mask int32, point cloud float32 in the world frame
    [m]. Joint data are (n,) float64 in [rad], [rad/s], [N m]; `gripper_pose` is the tip pose (7,) in the world.
    """

    left_shoulder_rgb: Array | None = None
    left_shoulder_depth: Array | None = None
    left_shoulder_mask: Array | None = None
    left_shoulder_point_cloud: Array | None = None
    right_shoulder_rgb: Array | None = None
    right_shoulder_depth: Array | None = None
    right_shoulder_mask: Array | None = None
    right_shoulder_point_cloud: Array | None = None
    overhead_rgb: Array | None = None
    overhead_depth: Array | None = None
    overhead_mask: Array | None = None
    overhead_point_cloud: Array | None = None
    wrist_rgb: Array | None = None
    wrist_depth: Array | None = None
    wrist_mask: Array | None = None
    wrist_point_cloud: Array | None = None
    front_rgb: Array | None = None
    front_depth: Array | None = None
    front_mask: Array | None = None
    front_point_cloud: Array | None = None
    joint_velocities: Array | None = None
    """Measured velocity of each arm joint, base first [rad/s]."""
    joint_positions: Array | None = None
    """Measured position of each arm joint [rad]."""
    joint_forces: Array | None = None
    """Torque that each motor applied in the last physics step, gravity included [N m]."""
    gripper_open: float | None = None
    """1 if the first finger is above 90 % of its range, otherwise 0."""
    gripper_pose: Array | None = None
    """Pose of the tip, the point between the fingertips, in the world: x, y, z [m], qx, qy, qz, qw."""
    gripper_matrix: Array | None = None
    """The same pose as a homogeneous matrix, tip to world."""
    gripper_joint_positions: Array | None = None
    """Position of each finger [m]; 0 is closed."""
    gripper_touch_forces: Array | None = None
    """Contact force on each finger, x, y, z in its own frame, left finger first [N]."""
    task_low_dim_state: Array | None = None
    """State of the objects of the task in the world; its length is constant for a task."""
    misc: dict[str, Any] = field(default_factory=dict)
    """Further values, by name."""
    ignore_collisions: InitVar[bool | None] = None

    def __post_init__(self, ignore_collisions: bool | None) -> None:
        """Set the `OptionalFields`, so that `Observation(**vars(observation))` makes a copy."""
        if ignore_collisions is not None:
            self.ignore_collisions = ignore_collisions

    def get_low_dim_data(self) -> Array:
        """Return the present low-dimensional fields as one vector, in the order of `LOW_DIM`."""
        values = (getattr(self, name) for name in LOW_DIM)
        parts = [np.atleast_1d(np.asarray(v, dtype=float)) for v in values if v is not None]
        return np.concatenate(parts) if parts else np.zeros(0)


PHASE, INTERVENTION = "phase", "intervention"
"""Keys of `misc` in recovery demonstrations."""
Disturbance = Literal["push", "slip", "stop"]
"""`push`: the gripper is pushed sideways; `slip`: the fingers release the held object; `stop`: the arm stops."""
DISTURBANCES: tuple[Disturbance, ...] = get_args(Disturbance)
"""Disturbances, which are also phases of a demonstration."""
TASK, RECOVERY = "task", "recovery"
"""The other phases."""
FIELDS: tuple[str, ...] = tuple(f.name for f in fields(Observation) if f.name != "misc")
"""The declared fields of observations, images first, without `misc`."""


class Demo(Sequence[Observation]):
    """One demonstration: a sequence of observations and the data to replay it.

    Args:
        observations: One per control tick, the first before any motion.
        random_seed: Seed of the episode; `reset(seed=...)` with it gives the same start state. Demonstrations of other programs
            have the state of the global numpy generator instead.
        num_reset_attempts: Number of placement attempts of the reset.
        variation_number: Variation of the task.
        instructions: Instructions, which describe the goal.
        state: Portable snapshot of the world at the first frame, name -> array.
        versions: Name -> version of the package and its libraries at the recording.
        attempt: Number of the attempt at the seed, from 0.
        task_name: Snake-case name of the task.
        robot: Name of the arm, or absolute path of its TOML file; empty in a demonstration of other programs.
        joint_names: Names of its joints, in the order of joint positions.
        factors: Factors of generalisation and their levels, such as `light_color:2`; empty for none.
        task_version: Version of the task, from 1.
    """

    random_seed: int | RandomState | None = (
        None  # with defaults of the class, an unpickled demo that lacks some of these can be used
    )
    num_reset_attempts: int | None = None
    variation_number: int = 0
    instructions: tuple[str, ...] = ()
    state: Mapping[str, Array] | None = None
    versions: Mapping[str, str] = MappingProxyType({})
    attempt: int = 0
    task_name: str = ""
    robot: str = ""
    joint_names: tuple[str, ...] = ()
    factors: str = ""
    task_version: int = 1

    def __init__(
        self,
        observations: Sequence[Observation],
        random_seed: int | RandomState | None = None,
        num_reset_attempts: int | None = None,
        variation_number: int = 0,
        instructions: Sequence[str] = (),
        state: Mapping[str, Array] | None = None,
        versions: Mapping[str, str] | None = None,
        attempt: int = 0,
        task_name: str = "",
        robot: str = "",
        joint_names: Sequence[str] = (),
        factors: str = "",
        task_version: int = 1,
    ) -> None:
        self._observations = list(as_several(observations, "Demo.observations"))  # type: ignore[arg-type]
        self.random_seed = random_seed
        self.num_reset_attempts = None if num_reset_attempts is None else as_whole(num_reset_attempts, "Demo.num_reset_attempts")
        self.variation_number = as_whole(variation_number, "Demo.variation_number")
        self.instructions = as_names(as_several(instructions, "Demo.instructions"), "Demo.instructions")
        self.state = None if state is None else dict(as_record(state, Mapping, "Demo.state"))  # type: ignore[type-abstract]
        self.versions = {} if versions is None else dict(as_record(versions, Mapping, "Demo.versions"))  # type: ignore[type-abstract]
        self.attempt = as_whole(attempt, "Demo.attempt")
        self.task_name = as_text(task_name, "Demo.task_name")
        self.robot = as_text(robot, "Demo.robot")
        self.joint_names = as_names(as_several(joint_names, "Demo.joint_names"), "Demo.joint_names")
        self.factors = as_text(factors, "Demo.factors")
        self.task_version = as_whole(task_version, "Demo.task_version", least=1)

    def with_observations(self, observations: Sequence[Observation]) -> Demo:
        """Return the same demonstration with other observations."""
        names = (
            "random_seed", "num_reset_attempts", "variation_number", "instructions", "state", "versions", "attempt",
            "task_name", "robot", "joint_names", "factors", "task_version",
        )  # fmt: skip
        return Demo(observations, **{name: getattr(self, name) for name in names})

    @property
    def seed(self) -> int | None:
        """`random_seed` if it is an integer; None if it is a generator state, or missing."""
        return int(self.random_seed) if is_whole(self.random_seed) else None

    def restore_state(self) -> None:
        """Set the global numpy generator from `random_seed`: an integer seeds it, a state is restored.

        This method is for programs that draw from that generator; this package does not. `TaskEnvironment.reset_to_demo` restores
        the start of the demonstration.

        Raises:
            TaskEnvironmentError: There is no seed, or it is neither an integer nor a state.
        """
        seed = self.random_seed
        if self.seed is not None and self.seed >= 0:
            np.random.seed(self.seed if self.seed < 2**32 else np.array(_words(self.seed)))  # noqa: NPY002
            return
        try:
            if not isinstance(seed, tuple):
                raise TypeError("it is not a tuple")
            np.random.set_state(seed)  # noqa: NPY002
        except (TypeError, ValueError, IndexError) as error:
            raise TaskEnvironmentError(
                f"The demonstration has random_seed={_shown(seed)}, so numpy's generator cannot be set ({error}). It needs a "
                "whole number >= 0, or what `numpy.random.get_state()` returned before the reset."
            ) from error

    def __len__(self) -> int:
        return len(self._observations)

    @overload
    def __getitem__(self, index: int) -> Observation: ...
    @overload
    def __getitem__(self, index: slice) -> list[Observation]: ...
    def __getitem__(self, index: int | slice) -> Observation | list[Observation]:
        return self._observations[index]

    def __iter__(self) -> Iterator[Observation]:
        return iter(self._observations)


def _words(number: int) -> list[int]:
    """Split an integer into words of 32 bits, the lowest first."""
    return [number >> shift & 0xFFFFFFFF for shift in range(0, number.bit_length(), 32)]


def _shown(seed: object) -> str:
    text = repr(seed)
    return text if len(text) <= 40 else f"{text[:40]}..."


__all__ = ["CAMERAS", "FIELDS", "LOW_DIM", "PRODUCTS", "Demo", "Observation", "OptionalFields"]
