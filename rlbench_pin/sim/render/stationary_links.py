"""Cache of stationary links in front of stationary cameras: drawn and coloured once, with shadows, until a part of it changes.

Afterwards they are part of the room. Only moving links are drawn, and the pixels of stationary links on which a moving link casts
a shadow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.backdrop import Painter
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.lighting import ShadowMap, spread
from rlbench_pin.sim.render.shading import KeptBackdrop, Sheet, light_blocks
from rlbench_pin.sim.render.shots import NumpyShooting, Shot


@dataclass(frozen=True, eq=False)
class StationaryLinks:
    """Stationary links in the cameras of a group."""

    backdrops: Sequence[KeptBackdrop]
    """The room as each camera sees it; with them if the camera is stationary."""
    is_kept: Sequence[bool]
    """Which cameras are stationary."""
    pixels: NDArray[np.int64]
    """Flat indices (n,) of the pixels that see them, image after image."""
    block: NDArray[np.int64]
    """Where each of these lies in the image of the key light, as the number of a block of four by four of its pixels (n,)."""
    shadows: ShadowMap
    """Their shadows."""

    def before(self, backdrops: Sequence[KeptBackdrop]) -> list[KeptBackdrop]:
        """Return the present room in the cameras, with stationary links where they are cached."""
        each = zip(self.backdrops, self.is_kept, backdrops, strict=True)
        return [kept if is_kept else room for kept, is_kept, room in each]

    def moving(
        self, shooting: NumpyShooting, number: int, limit: NDArray[np.float32]
    ) -> tuple[Shot, ShadowMap, NDArray[np.bool_]]:
        """Return the other links in a group of cameras, and the pixels that these shade.

        Args:
            shooting: The cameras of the instant.
            number: Number of the group.
            limit: Depth of the room in all their pixels (n,), which hides farther links [m].

        Returns:
            The visible pixels, all shadows, and which blocks of the image of the key light have other table shadows, (n, n).
        """
        blocked, changed = shooting.moving()
        shadows = ShadowMap(self.shadows.view, self.shadows.height, blocked, self.shadows)
        near = spread(changed)
        again = self.pixels.compress(near.ravel().take(self.block))
        return shooting.shot(number, limit, again), shadows, spread(spread(near))


def stationary_links(
    shooting: NumpyShooting,
    number: int,
    backdrops: Sequence[KeptBackdrop],
    room: Painter,
    colors: Callable[[Sheet, Shot, ShadowMap], NDArray[np.uint8]],
    light: CameraView,
    ids: NDArray[np.int32],
) -> StationaryLinks:
    """Draw stationary links in the stationary cameras of a group.

    Args:
        shooting: The cameras of the instant.
        number: Number of the group.
        backdrops: Their images of the room.
        room: The room.
        colors: Returns the colours (n, 3) of links with their shadows.
        light: Camera of the key light.
        ids: Mask ids of body b and link l at `[b, l + 1]`.
    """
    sheet = Sheet(backdrops, has_colors=True, has_ids=True)
    shot, blocked, is_kept = shooting.stationary(number, sheet.depth)
    shadows = ShadowMap(light, room.table_height, blocked)
    sheet.shade_tables(shadows, room.table_key)
    sheet.put_colors(shot, colors(sheet, shot, shadows))
    sheet.put_depth_and_ids(shot, ids)
    covered = np.zeros(len(sheet.depth), dtype=np.bool_)
    covered[shot.pixels] = True
    seen = [
        backdrop if not is_one else backdrop.with_stationary(sheet, n, covered, shadows)
        for n, (backdrop, is_one) in enumerate(zip(backdrops, is_kept, strict=True))
    ]
    return StationaryLinks(seen, is_kept, shot.pixels, light_blocks(shot, light), shadows)
