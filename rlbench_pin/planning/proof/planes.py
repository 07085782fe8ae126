"""How far shapes can close in along one direction while joints turn.

In the middle q_m of a piece two convex shapes A and B are a distance d apart along the unit normal n from A to B: B lies behind a
plane, A in front of it. With joint motions h = q - q_m in the hull of the piece's control points h_k, and |h_j| <= T_j, Taylor's
formula says of every point x of A

    n^T (x(q) - x(q_m)) <= max_k n^T J_x h_k + R,   R = 1/2 sum_ij T_i T_j l_max(i,j)          (1)

because |d2x / dq_i dq_j| is at most the lever l of x about the axis of the joint that is farther out. The first term is
linear in x, so that a box around A bounds it. Only joints between B and A count. Motion along the plane costs nothing but R.
"""

from __future__ import annotations

import numpy as np

from rlbench_pin.planning.proof.chain import cross
from rlbench_pin.planning.proof.poses import Poses
from rlbench_pin.planning.proof.shapes import IndexArray
from rlbench_pin.spatial import FloatArray


def advances(poses: Poses, piece: IndexArray, pair: IndexArray, normal: FloatArray) -> FloatArray:
    """Return how far the farther shapes of pairs come along normals (e, 3) on their pieces at most, equation (1), (e,), [m]."""
    shapes, pieces = poses.shapes, poses.pieces
    joint = np.arange(pieces.turns.shape[1])
    between = (joint >= shapes.depth[shapes.near[pair], None]) & (joint < shapes.depth[shapes.far[pair], None])
    steps, turns = pieces.steps[piece] * between[:, None], pieces.turns[piece] * between
    rest = 0.5 * (poses.levers_of(piece, pair) * turns * (2.0 * np.cumsum(turns, axis=1) - turns)).sum(axis=1)
    across = cross(normal[:, None], steps @ poses.arm.angular[piece])  # n^T (w x x) = (n x w)^T x, shape (e, 4, 3)
    shifts = steps @ poses.arm.linear[piece] @ normal[:, :, None]
    rotation, half = poses.box(piece, pair)
    moved = shifts + across @ poses.centers(piece, pair)[:, :, None] + np.abs(across @ rotation) @ half[:, :, None]
    return moved[:, :, 0].max(axis=1) + rest
