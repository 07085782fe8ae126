"""Things that are added: solids, meshes of one's own, assets that are found by words, free places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from rlbench_pin.assets import asset_path
from rlbench_pin.builder.custom_assets.mesh_asset import mesh_asset
from rlbench_pin.builder.custom_assets.uploads import UploadedMesh, UploadRefused
from rlbench_pin.builder.view.catalogue import catalogue, draw_triangles, model_size, primitive_urdf, search, thumbnail
from rlbench_pin.builder.view.placing import free_place
from rlbench_pin.errors import InvalidValue
from rlbench_pin.scene import BodySpec, SceneSpec
from rlbench_pin.urdf import read_urdf

RED = (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("kind", "size", "moments"),
    [
        ("box", (0.1, 0.2, 0.3), (0.13 / 6, 0.1 / 6, 0.05 / 6)),
        ("cylinder", (0.2, 0.3), (2 * (0.03 + 0.09) / 12, 2 * (0.03 + 0.09) / 12, 0.01)),
        ("sphere", (0.2,), (0.008, 0.008, 0.008)),
    ],
)
def test_solids_have_the_inertia_of_even_density(tmp_path: Path, kind: str, size: tuple[float, ...], moments: object) -> None:
    """Of 2 kg; what is seen is what is touched."""
    file = tmp_path / "thing.urdf"
    file.write_text(primitive_urdf("thing", kind, size, 2.0, RED))  # type: ignore[arg-type]
    link = read_urdf(file).links[0]
    assert link.inertial is not None
    assert [link.inertial.inertia[k] for k in (0, 3, 5)] == pytest.approx(list(moments), rel=1e-5)  # type: ignore[call-overload]
    assert link.visuals[0].kind == link.collisions[0].kind == kind
    assert link.visuals[0].color == (1.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("size", "mass"), [((0.1, 0.1), 1.0), ((0.1, 0.1, 0.0), 1.0), ((0.1, 0.1, 9.0), 1.0), ((0.1, 0.1, 0.1), 0.0)]
)
def test_solids_that_are_none_are_refused(size: tuple[float, ...], mass: float) -> None:
    """Of no size, of no mass, or as large as a room."""
    with pytest.raises(InvalidValue):
        primitive_urdf("thing", "box", size, mass, RED)


def test_a_hollow_mesh_is_taken_apart(tmp_path: Path) -> None:
    """The parts of an L leave its notch free, and together weigh what was asked."""
    bars = [trimesh.creation.box((0.2, 0.04, 0.04)), trimesh.creation.box((0.04, 0.04, 0.2))]
    bars[1].apply_translation((0.08, 0.0, 0.1))
    made = mesh_asset(UploadedMesh("angle", trimesh.boolean.union(bars)), 1.0, 0.5, RED)
    for name, content in made.files.items():
        (tmp_path / name).write_bytes(content)
    link = read_urdf(tmp_path / made.urdf).links[0]
    assert len(link.collisions) >= 2
    assert link.inertial is not None
    assert link.inertial.mass == 0.5


@pytest.mark.parametrize(("scale", "why"), [(100.0, "the limit is 2 m"), (1e-5, "too small")])
def test_meshes_of_wrong_size_are_refused(scale: float, why: str) -> None:
    """With the scale as the next step."""
    with pytest.raises(UploadRefused, match=why):
        mesh_asset(UploadedMesh("cube", trimesh.creation.box((0.1, 0.1, 0.1))), scale, 1.0, RED)


def test_assets_are_found_by_their_words() -> None:
    """Names first, then what is said of them; every asset has an image."""
    assets = catalogue()
    assert len(assets) > 100
    assert search(assets, "cup")[0].name == "cup"
    assert "ring_marker" in [asset.name for asset in search(assets, "visual only")]
    assert search(assets, "no such thing") == []
    image = thumbnail(asset_path("objects/cup/cup.urdf"))
    assert image.shape == (128, 128, 3)
    assert float(np.ptp(image)) > 50.0
    assert model_size(asset_path("objects/cube_45/cube_45.urdf")) == pytest.approx((0.045, 0.045, 0.045))


def test_what_is_nearer_hides_what_is_behind() -> None:
    """Pixel by pixel, in whatever order; of two in one plane, such as a label on a box, the later is seen."""
    points = np.array([[[0, 0], [20, 0], [0, 20]], [[0, 0], [20, 0], [0, 20]]], float)
    depths = np.array([[0.0, 1.0, 1.0], [1.0, 0.0, 1.0]])
    shades = np.array([[255, 0, 0], [0, 0, 255]], np.uint8)
    there, back = np.zeros((20, 20, 3), np.uint8), np.zeros((20, 20, 3), np.uint8)
    draw_triangles(there, points, depths, shades)
    draw_triangles(back, points[::-1], depths[::-1], shades[::-1])
    np.testing.assert_array_equal(there, back)
    assert there[1, 3].tolist() == [0, 0, 255]
    assert there[1, 15].tolist() == [255, 0, 0]
    assert there[18, 18].tolist() == [0, 0, 0]
    draw_triangles(there, points, np.zeros((2, 3)), shades)
    assert set(map(tuple, there.reshape(-1, 3).tolist())) == {(0, 0, 0), (0, 0, 255)}


def test_a_new_body_stands_beside_what_is_there() -> None:
    """On the table, not in another body."""
    cube = BodySpec(name="cube", asset="objects/cube/cube.urdf", pose=(0.0, 0.0, 0.025, 0.0, 0.0, 0.0, 1.0))
    x, y, z = free_place(SceneSpec(format=2, body=(cube,)), cube.model_copy(update={"name": "other"}))
    assert z == pytest.approx(0.025)
    assert max(abs(x), abs(y)) >= 0.06
