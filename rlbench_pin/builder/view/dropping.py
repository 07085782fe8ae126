"""The body over which a thing is dragged, and on which it hangs when it is let go there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from viser import BoxHandle, SceneApi

from rlbench_pin.builder.view.snapping import body_triangles
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import PosedSpec
from rlbench_pin.spatial import FloatArray

_BESIDE, _INSIDE = 0.02, 0.03
"""So far beside a body one is still over it, and so far below its top; the gizmo is seldom hit exactly [m]."""
_YELLOW = (255, 200, 0)


class Targets:
    """What a thing that is being dragged can be dropped onto: all bodies that do not hang on it.

    Args:
        spec: The scene.
        links: World pose (7,) of each link, by `<body>/<link>`.
        name: What is dragged.
    """

    def __init__(self, spec: SceneSpec, links: Mapping[str, FloatArray], name: str) -> None:
        self._boxes: dict[str, FloatArray] = {}
        for body in spec.body:
            corners = body_triangles(spec, body, links).reshape(-1, 3)
            if len(corners) and not hangs_on(spec, body, name):
                self._boxes[body.name] = np.array([corners.min(axis=0), corners.max(axis=0)])

    def below(self, point: FloatArray) -> str:
        """Return the body over or in which a world point (3,) is, the highest of several; empty where there is none."""
        found = [
            (box[1, 2], name)
            for name, box in self._boxes.items()
            if (box[0, :2] - _BESIDE <= point[:2]).all()
            and (point[:2] <= box[1, :2] + _BESIDE).all()
            and (point[2] >= box[1, 2] - _INSIDE or (box[0] <= point).all() and (point <= box[1]).all())
        ]
        return max(found)[1] if found else ""

    def box(self, name: str) -> FloatArray:
        """Return the lowest and the highest corner (2, 3) of a body in the world [m]."""
        return self._boxes[name].copy()


class DropMark:
    """Draws a box of lines around the body onto which a thing would be dropped.

    Args:
        scene: Where to draw.
    """

    def __init__(self, scene: SceneApi) -> None:
        self._scene = scene
        self._shown = ""
        self._node: BoxHandle | None = None

    @property
    def shown(self) -> str:
        """The body that is marked; empty when none is."""
        return self._shown

    def show(self, name: str, box: FloatArray | None = None) -> None:
        """Mark a body whose lowest and highest corner (2, 3) are given; none without a name."""
        if name == self._shown:
            return
        if self._node is not None:
            self._node.remove()
            self._node = None
        self._shown = name
        if box is not None:
            size, middle = box[1] - box[0] + 0.01, 0.5 * (box[0] + box[1])
            self._node = self._scene.add_box("/drop", _YELLOW, tuple(size), wireframe=True, cast_shadow=False, position=middle)


def hangs_on(spec: SceneSpec, thing: PosedSpec, name: str) -> bool:
    """Whether a thing is the one of that name, or moves with it."""
    parents = {other.name: other.parent.partition("/")[0] for other in spec.posed()}
    here = thing.name
    for _ in range(len(parents) + 1):
        if here == name:
            return True
        here = parents.get(here, "")
    return False
