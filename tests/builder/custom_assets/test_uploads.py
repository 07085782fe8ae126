"""Files that are sent are what they say, or are refused with the reason."""

from __future__ import annotations

import pytest

from rlbench_pin.builder.custom_assets.uploads import MAX_TRIANGLES, UploadRefused, check_size, read_mesh, upload_stem
from rlbench_pin.builder.server import MAX_UPLOAD_SIZE

TETRAHEDRON = b"mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def test_a_mesh_is_read_without_its_materials() -> None:
    """No file that it names is opened."""
    uploaded = read_mesh("My Handle-2.OBJ", TETRAHEDRON)
    assert uploaded.name == "my_handle_2"
    assert len(uploaded.mesh.faces) == 4
    assert uploaded.mesh.volume == pytest.approx(1 / 6)


@pytest.mark.parametrize(
    ("name", "data", "why"),
    [
        ("a.obj", b"", "empty"),
        ("a.exe", b"MZ", "'.exe'"),
        ("a.obj", b"v 0 0 0\n", "no triangles"),
        ("a.obj", b"\xff\xfe\x00" * 100, "a.obj"),
        ("a.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj"),
        ("a.obj", b"v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "farther"),
        ("a.obj", b"v 0 0 0\nf 1 2 99\n", "a.obj"),
        ("a.obj", b"v 0 0 0\n" + b"f 1 1 1\n" * (MAX_TRIANGLES + 1), "faces"),
        ("a.obj", b"f " + b"1 " * 100_000, "characters"),
        ("a.stl", bytes(80) + (2**31).to_bytes(4, "little"), "faces"),
    ],
)
def test_what_is_no_mesh_is_refused(name: str, data: bytes, why: str) -> None:
    """Each with its reason."""
    with pytest.raises(UploadRefused, match=why):
        read_mesh(name, data)


def test_what_is_too_large_is_refused() -> None:
    """Before anything is read."""
    with pytest.raises(UploadRefused, match="larger than 64 MB. Reduce it"):
        check_size("a.obj", MAX_UPLOAD_SIZE + 1)


@pytest.mark.parametrize(("name", "stem"), [("../../x.obj", "x"), ("7.obj", "object_7"), ("É.stl", "object"), ("a.b.obj", "a_b")])
def test_stems_are_names_of_a_scene(name: str, stem: str) -> None:
    """Small letters, digits and `_`, no folder."""
    assert upload_stem(name) == stem
