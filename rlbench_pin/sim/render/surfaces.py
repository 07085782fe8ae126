"""Points and normals of what a camera sees, from its depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView


def points_at(view: CameraView, pixels: NDArray[np.int64], depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """World points (n, 3) [m] of some pixels.

    Args:
        view: The camera.
        pixels: Flat indices (n,) of the pixels.
        depth: Their depth (n,) [m].
    """
    return view.rays[pixels] * depth[:, None] + view.extrinsics()[:3, 3].astype(np.float32)


def normals_at(view: CameraView, pixels: NDArray[np.int64], inverse: NDArray[np.float32]) -> NDArray[np.float32]:
    """Unit normals (n, 3) in the world of the surfaces at some pixels.

    On a plane m . P = 1 the inverse depth is m . ray, affine over the picture; its slopes therefore give m. At edges the smaller
    of the two one-sided slopes is that of the surface itself.

    Args:
        view: The camera.
        pixels: Flat indices (n,) of the pixels.
        inverse: Inverse depth (h, w) of the whole picture [1/m].
    """
    width = view.size[0]
    padded = np.pad(inverse, 1, constant_values=np.float32(1e9)).ravel()
    v, u = np.divmod(pixels, width)
    at = (v + 1) * (width + 2) + u + 1
    here = padded[at]
    slope_u = _smaller(padded[at + 1] - here, here - padded[at - 1])
    slope_v = _smaller(padded[at + width + 2] - here, here - padded[at - width - 2])
    k = view.intrinsics().astype(np.float32)
    depth_part = here - slope_u * (u - k[0, 2]) - slope_v * (v - k[1, 2])
    outward = -np.stack([slope_u * k[0, 0], slope_v * k[1, 1], depth_part], axis=1, dtype=np.float32)
    outward /= np.maximum(np.sqrt(np.einsum("ij,ij->i", outward, outward)), 1e-12)[:, None]
    return outward @ view.extrinsics()[:3, :3].T.astype(np.float32)


def _smaller(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(np.abs(a) < np.abs(b), a, b)
