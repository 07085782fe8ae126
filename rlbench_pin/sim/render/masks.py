"""Stable mask ids of all links, and their segmentation values in PyBullet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import RobotModelError
from rlbench_pin.sim.body import LoadedModel

FIRST_OBJECT = 61
"""Robot and room have ids below, task objects from here on."""
_LINK_SHIFT = 24
_BODY_BITS = (1 << _LINK_SHIFT) - 1


def segment_of(body: int, link: int) -> int:
    """Return the segmentation value of a link, body + (link + 1) << 24, by PyBullet's numbers of body and link."""
    return body + ((link + 1) << _LINK_SHIFT)


def bodies_of(segments: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return PyBullet's numbers of the bodies of segmentation values."""
    return segments & _BODY_BITS


def rows_of(segments: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return PyBullet's numbers of the links of segmentation values, plus one."""
    return segments >> _LINK_SHIFT


class MaskTable:
    """Gives each link of each body an id, in the order in which they are added.

    Attributes:
        names: Id -> `<body>`, or `<body>/<link>` when the body has several links.
    """

    def __init__(self) -> None:
        self.names: dict[int, str] = {}
        self._next = 1
        self._ids: dict[int, NDArray[np.int32]] = {}
        self._table: NDArray[np.int32] | None = None

    def begin_objects(self) -> None:
        """Start the numbering of task objects."""
        if self._next > FIRST_OBJECT:
            raise RobotModelError(
                f"Robot and room have {self._next - 1} links, at most {FIRST_OBJECT - 1} are possible. Choose another arm."
            )
        self._next = FIRST_OBJECT

    def add(self, name: str, model: LoadedModel) -> None:
        """Number the links of a body, base first."""
        links = tuple(model.links)
        ids = range(self._next, self._next + len(links))
        for identifier, link in zip(ids, links, strict=True):
            self.names[identifier] = name if len(links) == 1 else f"{name}/{link}"
        self._ids[model.uid] = np.array(ids, dtype=np.int32)
        self._next = ids.stop
        self._table = None

    def first_id(self, model: LoadedModel) -> int:
        """Id of the base link of a body."""
        return int(self._ids[model.uid][0])

    def remove(self, model: LoadedModel) -> None:
        """Remove a body; ids at the end of the sequence become free again."""
        for identifier in self._ids.pop(model.uid).tolist():
            del self.names[identifier]
        self._next = max(FIRST_OBJECT, max(self.names) + 1)
        self._table = None

    def table(self) -> NDArray[np.int32]:
        """Ids by PyBullet's numbers: body b, link l at `[b, l + 1]`; a last row of zeros for the background."""
        if self._table is None:
            width = max(len(ids) for ids in self._ids.values())
            self._table = np.zeros((max(self._ids) + 2, width), dtype=np.int32)
            for uid, ids in self._ids.items():
                self._table[uid, : len(ids)] = ids
        return self._table
