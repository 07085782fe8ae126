"""The arm's visual meshes: fewer triangles that keep the edges and the normals of many."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))

from assets_lib.arm_appearance import light_appearances
from assets_lib.collapse import collapse, quadrics_of, sharp_edges
from assets_lib.decimate import weld, without_small_holes
from assets_lib.mesh import Mesh, cylinder, icosphere

WHITE, BLACK = (1.0, 1.0, 1.0), (0.2, 0.2, 0.2)


def _plate(size: int) -> Mesh:
    """A flat square of 1 m with many triangles."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, size), np.linspace(0.0, 1.0, size), indexing="ij")
    index = np.arange(size * size).reshape(size, size)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return Mesh(np.column_stack([x.ravel(), y.ravel(), np.zeros(size * size)]), faces)


def _area(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def test_a_flat_plate_keeps_its_border() -> None:
    """A square of 450 triangles becomes a few that cover the same square."""
    plate = _plate(16)
    edges, uprights = sharp_edges(plate, 0.7)
    light = collapse([plate], [quadrics_of(plate, edges, uprights, np.full(len(edges), 0.3))], 4)[0]
    assert len(light.faces) <= 12
    assert abs(_area(light) - 1.0) < 1e-6
    assert np.allclose(light.bounds(), plate.bounds(), atol=1e-6)


def test_a_ball_stays_round_and_shines_as_before() -> None:
    """Points stay near the sphere, and normals point away from its middle."""
    looks = light_appearances({"ball": [(WHITE, icosphere(0.05, 4))]}, {}, 300)
    mesh, normals = looks[0].piece.mesh, looks[0].normals
    assert len(mesh.faces) <= 300
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 0.05).max() < 0.001
    outwards = mesh.vertices[mesh.faces] / 0.05
    assert (normals * outwards).sum(axis=2).min() > 0.99


@pytest.mark.simulation
def test_pieces_share_the_triangles_and_keep_their_colours() -> None:
    """A closed drum and a dark plate above it: both stay, the sharp rim of the drum too, and what the plate hides may go."""
    drum = weld(cylinder(0.05, 0.1, 200), 5)
    plate = Mesh((_plate(12).vertices - [0.5, 0.5, 0.0]) * 0.05 + [0.0, 0.0, 0.052], _plate(12).faces)
    looks = light_appearances({"drum": [(WHITE, drum), (BLACK, plate)]}, {}, 120)
    assert [look.piece.color for look in looks] == [WHITE, BLACK]
    assert sum(len(look.piece.mesh.faces) for look in looks) <= 120
    assert np.allclose(looks[0].piece.mesh.bounds(), drum.bounds(), atol=0.001)
    flat = np.abs(looks[0].normals[..., 2])
    assert ((flat > 0.99) | (flat < 0.01)).all()


def test_small_holes_are_closed_and_large_ones_stay() -> None:
    """A missing triangle becomes a fan of three; the border of the plate itself is no hole."""
    plate = _plate(10)
    torn = Mesh(plate.vertices, np.delete(plate.faces, 40, axis=0))
    closed = without_small_holes(torn, 0.5)
    assert len(closed.faces) == len(torn.faces) + 3
    assert abs(_area(closed) - 1.0) < 1e-9
