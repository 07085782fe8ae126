"""From poses to configurations.

Three descents solve inverse kinematics:

* `ik.descend` (damped least squares, many starts) is what planning uses: exact to 1e-6, bounded steps, given up early, because
  there is always another start.
* `pinned_ik.solve_pinned_ik` has one start and joints that must not move: damped ten times less, never given up early. With the
  damping and the early end of `ik.descend`, 2 % of random poses that it reaches would be lost.
* `control.PoseIK` solves a QP in each step, by PlaCo, with joint limits and a trust region as its constraints.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.planning.kinematics.goals import PoseRegion, self_motions, symmetric_poses
from rlbench_pin.planning.kinematics.ik import Descent, descend, solve_ik
from rlbench_pin.planning.kinematics.pinned_ik import solve_pinned_ik

__all__ = [
    "Descent",
    "PoseRegion",
    "descend",
    "self_motions",
    "solve_ik",
    "solve_pinned_ik",
    "symmetric_poses",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
