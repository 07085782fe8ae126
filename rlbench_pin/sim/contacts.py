"""Which bodies touch, where, and how hard."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.loaded_model import LoadedModel
from rlbench_pin.spatial import FloatArray

TOUCH_DISTANCE = 5e-4
"""Surfaces closer than this touch [m]; the solver keeps resting objects apart by about as much."""


@dataclass(frozen=True, eq=False)
class Contact:
    """One contact point of the last physics step."""

    body: str
    link: str
    other: str
    other_link: str
    position: FloatArray
    """Point on `other` in the world (3,) [m]."""
    normal: FloatArray
    """Unit vector (3,) from `other` towards `body`."""
    distance: float
    """Gap between the surfaces [m]; negative when they overlap."""
    force: float
    """Normal force [N]."""


class ContactReader:
    """Reads contact points and translates PyBullet's numbers to names.

    Args:
        client: The physics server.
    """

    def __init__(self, client: PhysicsClient) -> None:
        self._client = client
        self._names: dict[int, tuple[str, LoadedModel, dict[int, str]]] = {}

    def add(self, name: str, model: LoadedModel) -> None:
        """Make a body known."""
        self._names[model.uid] = (name, model, {index: link for link, index in model.links.items()})

    def remove(self, uid: int) -> None:
        """Forget a body."""
        del self._names[uid]

    def read(self, body: int | None = None, other: int | None = None) -> tuple[Contact, ...]:
        """Return the contact points of the last physics step, of one body, or between two."""
        return tuple(self._contact(p) for p in self._points(body, other))

    def touching(self, body: int) -> tuple[str, ...]:
        """Names of the bodies that touch `body`, sorted."""
        near = {p[2] for p in self._points(body, None) if p[8] < TOUCH_DISTANCE}
        return tuple(sorted(self._names[uid][0] for uid in near if uid != body))

    def forces(self, body: int) -> dict[tuple[str, str], float]:
        """Return (link of `body`, what it touches) -> sum of the normal forces of the last physics step [N]."""
        forces: dict[tuple[str, str], float] = {}
        links = self._names[body][2]
        for point in self._points(body, None):
            if point[2] != body and point[8] < TOUCH_DISTANCE:
                pair = links[point[3]], self._names[point[2]][0]
                forces[pair] = forces.get(pair, 0.0) + point[9]
        return forces

    def deepest(self) -> float:
        """Largest overlap of any two surfaces [m], 0 when there is none."""
        return max(0.0, *(-p[8] for p in self._points(None, None)), 0.0)

    def _points(self, body: int | None, other: int | None) -> tuple:
        which = {key: uid for key, uid in (("bodyA", body), ("bodyB", other)) if uid is not None}
        return bullet.getContactPoints(physicsClientId=self._client.id, **which) or ()

    def _contact(self, point: tuple) -> Contact:
        name, _, links = self._names[point[1]]
        other, _, other_links = self._names[point[2]]
        return Contact(
            name, links[point[3]], other, other_links[point[4]], np.array(point[6]), np.array(point[7]), point[8], point[9]
        )


def touched_links(model: LoadedModel, link: int, other: LoadedModel) -> set[int]:
    """Return the indices of the links of `other` that a link of `model` touched in the last physics step."""
    where = {"bodyA": model.uid, "bodyB": other.uid, "linkIndexA": link, "physicsClientId": model.client.id}
    return {point[4] for point in bullet.getContactPoints(**where) or () if point[8] < TOUCH_DISTANCE}
