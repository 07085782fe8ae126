"""Image noise: blur, JPEG artefacts, exposure, dead pixels, and noise of the depth."""

from __future__ import annotations

import io
import zlib
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image, ImageFilter

_RGB = "RGB"


@dataclass(frozen=True)
class ImageNoise:
    """Image noise of all cameras in one episode; the defaults add no noise."""

    exposure: float = 0.0
    """Brightness of colour images in powers of two; what is too bright is clipped."""
    blur: float = 0.0
    """Standard deviation of the blur as a share of the image height."""
    dead_share: float = 0.0
    """Share of the pixels that are black or white."""
    jpeg_quality: int = 0
    """Quality of JPEG compression, 1 to 95; 0 is none."""
    depth_sigma: float = 0.0
    """Standard deviation of the depth at 1 m [m]; it grows with the square of the depth."""
    seed: int = 0
    """Seed of the places of dead pixels."""

    def apply(self, rgb: np.ndarray, camera: str) -> np.ndarray:
        """Return a colour image with noise, uint8 (h, w, 3).

        Args:
            rgb: The image, which does not change.
            camera: Name of the camera; each has its own dead pixels.
        """
        if self.blur > 0.0:
            image = Image.fromarray(rgb, _RGB).filter(ImageFilter.GaussianBlur(self.blur * rgb.shape[0]))
            rgb = np.asarray(image)
        if self.exposure != 0.0:
            levels = np.minimum(np.arange(256) * 2.0**self.exposure, 255.0)
            rgb = np.rint(levels).astype(np.uint8)[rgb]
        if self.dead_share > 0.0:
            places, values = _dead_pixels(self.seed, camera, rgb.shape[0] * rgb.shape[1], self.dead_share)
            rgb = rgb.copy()
            rgb.reshape(-1, 3)[places] = values
        if self.jpeg_quality > 0:
            stored = io.BytesIO()
            Image.fromarray(rgb, _RGB).save(stored, "JPEG", quality=self.jpeg_quality)
            rgb = np.array(Image.open(stored))
        return rgb if rgb.flags.writeable else rgb.copy()

    def apply_to_depth(self, metres: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return depth [m] with normal noise, float32 (h, w); draw only from `rng`, and only if there is noise."""
        if self.depth_sigma <= 0.0:
            return metres
        noise = rng.standard_normal(metres.shape, dtype=np.float32)
        return np.maximum(metres + self.depth_sigma * metres**2 * noise, 0.0).astype(np.float32)


@lru_cache(maxsize=64)
def _dead_pixels(seed: int, camera: str, count: int, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Return flat indices (n,) of the dead pixels of a camera with `count` pixels, and their values (n, 1), 0 or 255."""
    rng = np.random.default_rng((seed, zlib.crc32(camera.encode())))
    places = np.flatnonzero(rng.random(count) < share)
    return places, np.where(rng.random(len(places)) < 0.5, 0, 255).astype(np.uint8)[:, None]
