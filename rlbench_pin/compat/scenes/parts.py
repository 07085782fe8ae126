"""What a scene holds by names that programs know: its cameras, its workspace, the callback of its steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from pyrep.const import ObjectType
from pyrep.objects.dummy import Dummy
from pyrep.objects.shape import Shape
from pyrep.objects.vision_sensor import VisionSensor
from rlbench_pin.compat.scenes.workspace import Workspace
from rlbench_pin.environment.runtime import TIP_WORKSPACE


class SceneParts:
    """Views on things of the scene, made when they are first asked for; they hold no copy of state.

    The underscored names are those that programs written for RLBench read.
    """

    robot: Any
    _start_arm_joint_pos: Sequence[float] | np.ndarray

    def __init__(self) -> None:
        self._step_callback: Callable[[], None] | None = None
        low, high = TIP_WORKSPACE.tolist()
        self._workspace_minx, self._workspace_miny, self._workspace_minz = low
        self._workspace_maxx, self._workspace_maxy, self._workspace_maxz = high

    def prepare(self) -> None:
        """Put the arm where `_start_arm_joint_pos` says, when a program says another posture than that of the robot file."""
        if not np.array_equal(self._start_arm_joint_pos, self.robot.arm.get_joint_positions()):
            self.robot.arm.set_joint_positions(self._start_arm_joint_pos, disable_dynamics=True)

    def check_target_in_workspace(self, pos: Sequence[float] | np.ndarray) -> bool:
        """Whether a target (3,) [m] is strictly inside the workspace."""
        x, y, z = (float(value) for value in pos)
        return bool(
            self._workspace_minx < x < self._workspace_maxx
            and self._workspace_miny < y < self._workspace_maxy
            and self._workspace_minz < z < self._workspace_maxz
        )

    def register_step_callback(self, func: Callable[[], None] | None) -> None:
        """Call `func` after every control tick, in place of what was registered before; None calls nothing."""
        self._step_callback = func

    def _after_step(self) -> None:
        if self._step_callback is not None:
            self._step_callback()

    @cached_property
    def _workspace(self) -> Shape:
        return Shape("workspace")

    @cached_property
    def _workspace_boundary(self) -> Workspace:
        return Workspace(self._workspace)

    @cached_property
    def target_workspace_check(self) -> Dummy:
        """A dummy that programs move to targets."""
        return Dummy.create()

    @cached_property
    def _cam_over_shoulder_left(self) -> VisionSensor:
        return VisionSensor("cam_over_shoulder_left")

    @cached_property
    def _cam_over_shoulder_right(self) -> VisionSensor:
        return VisionSensor("cam_over_shoulder_right")

    @cached_property
    def _cam_overhead(self) -> VisionSensor:
        return VisionSensor("cam_overhead")

    @cached_property
    def _cam_wrist(self) -> VisionSensor:
        return VisionSensor("cam_wrist")

    @cached_property
    def _cam_front(self) -> VisionSensor:
        return VisionSensor("cam_front")

    @cached_property
    def _cam_over_shoulder_left_mask(self) -> VisionSensor:
        return VisionSensor("cam_over_shoulder_left_mask")

    @cached_property
    def _cam_over_shoulder_right_mask(self) -> VisionSensor:
        return VisionSensor("cam_over_shoulder_right_mask")

    @cached_property
    def _cam_overhead_mask(self) -> VisionSensor:
        return VisionSensor("cam_overhead_mask")

    @cached_property
    def _cam_wrist_mask(self) -> VisionSensor:
        return VisionSensor("cam_wrist_mask")

    @cached_property
    def _cam_front_mask(self) -> VisionSensor:
        return VisionSensor("cam_front_mask")

    @cached_property
    def _robot_shapes(self) -> list[Any]:
        return list(self.robot.arm.get_objects_in_tree(object_type=ObjectType.SHAPE))
