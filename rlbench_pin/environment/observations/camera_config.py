"""What one camera delivers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar, Literal

from rlbench_pin.environment.observations.noise import Identity, NoiseModel, as_noise
from rlbench_pin.errors import CameraError, InvalidCamera, UnknownName
from rlbench_pin.values import FLAG, Rule, Settings, as_picture_size, ruled

RenderMode = Literal["opengl", "opengl3"]
"""With shadows, `opengl3`, or without."""

PICTURE_SIZE: Rule = partial(as_picture_size, error=InvalidCamera)


@dataclass(kw_only=True)
class CameraConfig(Settings):
    """What one camera delivers at each observation.

    Raises:
        InvalidValue: A setting is given a value that makes no sense, at any time.
        UnknownSetting: There is no such setting (also an AttributeError).
    """

    rules: ClassVar[Mapping[str, Rule]] = ruled(
        (FLAG, "rgb depth point_cloud mask masks_as_one_channel depth_in_meters antialiasing"),
        (as_noise, "rgb_noise depth_noise"),
        (PICTURE_SIZE, "image_size"),
    )

    rgb: bool = True
    """Colours, uint8 (h, w, 3)."""
    rgb_noise: NoiseModel = field(default_factory=Identity)
    """Applied to colours in 0..1."""
    depth: bool = True
    """Depth along the optical axis, float32 (h, w): 0..1 from the near to the far plane, or [m] with `depth_in_meters`."""
    depth_noise: NoiseModel = field(default_factory=Identity)
    """Applied to depth in [m], before the point cloud."""
    point_cloud: bool = True
    """World coordinates of every pixel, float32 (h, w, 3) [m]."""
    mask: bool = True
    """Id of the thing seen by every pixel, int32 (h, w); `misc["mask_names"]` has the names."""
    image_size: tuple[int, int] = (128, 128)
    """Width and height [px]; one number stands for both."""
    render_mode: RenderMode = "opengl3"
    """`opengl3` draws shadows, `opengl` is faster without."""
    antialiasing: bool = False
    """Each colour is the mean of two by two, so that edges and thin lines are smooth, and with shadows the table is darker around
    what stands on it; depth and masks stay as they are. Colours take about four times as long."""
    masks_as_one_channel: bool = True
    """Masks as one integer per pixel; otherwise (h, w, 3) float32 in 0..1 with the id spread over the channels."""
    depth_in_meters: bool = False
    """Depth in [m]; otherwise 0..1, linear between the near and the far plane."""

    def set_all(self, value: bool) -> None:
        """Switch rgb, depth, point cloud and mask together."""
        self.rgb = self.depth = self.point_cloud = self.mask = value

    @property
    def is_used(self) -> bool:
        """Whether any product is wanted."""
        return self.rgb or self.depth or self.point_cloud or self.mask

    @property
    def draws_shadows(self) -> bool:
        """Whether things cast shadows on each other."""
        return self.render_mode == "opengl3"

    def noise_of(self, product: Literal["rgb", "depth"]) -> NoiseModel:
        """Return the noise of colours or of depth."""
        return self.rgb_noise if product == "rgb" else self.depth_noise

    def check(self, name: str) -> None:
        """Raise CameraError when the settings make no picture."""
        width, height = self.image_size
        if width < 1 or height < 1:
            raise CameraError(f"Camera '{name}' has image_size {self.image_size}; width and height must be at least 1 px.")
        if not isinstance(self.render_mode, str) or self.render_mode not in ("opengl", "opengl3"):
            raise UnknownName("render mode", self.render_mode, ("opengl", "opengl3"))
