"""Whatever is sent as a mesh, a URDF file or an archive: taken, or refused with its reason; nothing else is touched."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from rlbench_pin.builder.custom_assets.uploads import UploadRefused, read_archive, read_mesh
from rlbench_pin.errors import RlbenchPinError
from tests.builder.custom_assets.files import LINK, angle, make, obj, put, stl, zipped

MESH = '<robot name="a"><link name="a"><collision><geometry><mesh filename="{}"/></geometry></collision></link></robot>'
JOINT = '<joint name="{0}{1}" type="revolute"><parent link="{0}"/><child link="{1}"/><limit lower="0" upper="1"/></joint>'
BOX = '<robot name="a"><link name="a"><inertial><mass value="{}"/></inertial>{}</link></robot>'


def _robot(*parts: str) -> str:
    return f'<robot name="a">{"".join(parts)}</robot>'


def _shape(shape: str) -> str:
    return BOX.format("1", f"<collision><geometry>{shape}</geometry></collision>")


BOMB = (
    '<!DOCTYPE r [<!ENTITY a "ha">' + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi")) + "]>"
)
TEXTS = {
    "billion laughs": (f'{BOMB}<robot name="&i;"/>', "entities"),
    "external entity": ('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="a">&x;</robot>', "entities"),
    "external type": ('<!DOCTYPE robot SYSTEM "http://127.0.0.1:9/x.dtd"><robot name="a"/>', "document type"),
    "deep": ("<robot>" + "<a>" * 5000 + "</a>" * 5000 + "</robot>", "nested ones"),
    "many": ("<robot>" + "<a/>" * 30_000 + "</robot>", "elements"),
    "long": ("<robot>" + " " * 5_000_000 + "</robot>", "MB of XML"),
    "no xml": ("<robot", "not valid XML"),
    "other encoding": ('<?xml version="1.0" encoding="no-such"?><robot/>', "not valid XML"),
    "no robot": ("<sdf/>", "not <robot>"),
    "no link": (_robot(), "0 links"),
    "two roots": (_robot(LINK.format("b"), LINK.format("c")), "2 roots: b, c"),
    "circle": (_robot(*(LINK.format(n) for n in "bcd"), JOINT.format("c", "d"), JOINT.format("d", "c")), "cycle: c -> d -> c"),
    "whole circle": (_robot(LINK.format("b"), LINK.format("c"), JOINT.format("b", "c"), JOINT.format("c", "b")), "cycle"),
    "own parent": (_robot(LINK.format("b"), JOINT.format("b", "b")), "cycle"),
    "two parents": (_robot(*(LINK.format(n) for n in "bcd"), JOINT.format("b", "d"), JOINT.format("c", "d")), "two joints"),
    "no such link": (_robot(LINK.format("b"), JOINT.format("b", "z")), "'z', which does not exist"),
    "same names": (_robot(LINK.format("b"), LINK.format("b")), "two <link>"),
    "nameless": (_robot(LINK.format("")), "no name"),
    "floating": (
        _robot(LINK.format("b"), LINK.format("c"), JOINT.format("b", "c").replace("revolute", "floating")),
        "'floating'",
    ),
    "no axis": (
        _robot(LINK.format("b"), LINK.format("c"), JOINT.format("b", "c").replace("<l", '<axis xyz="0 0 0"/><l')),
        "axis",
    ),
    "limits": (_robot(LINK.format("b"), LINK.format("c"), JOINT.format("b", "c").replace('"1"', '"-1"')), "0 to -1"),
    "endless": (_robot(LINK.format("b"), LINK.format("c"), JOINT.format("b", "c").replace('"1"', '"inf"')), "finite"),
    "negative mass": (BOX.format("-1", ""), "0 or more"),
    "mass nan": (BOX.format("nan", ""), "finite"),
    "mass of a star": (BOX.format("99999", ""), "99999 kg"),
    "negative size": (_shape('<box size="0.1 -0.1 0.1"/>'), "above 0"),
    "no size": (_shape("<box/>"), "finite"),
    "infinite": (_shape('<sphere radius="inf"/>'), "finite"),
    "house": (_shape('<cylinder radius="5" length="5"/>'), "at most 2"),
    "unknown shape": (_shape("<teapot/>"), "<teapot>"),
    "negative scale": (_shape('<mesh filename="a.obj" scale="1 -1 1"/>'), "above 0"),
    "absolute": (MESH.format("/etc/passwd"), "/etc/passwd"),
    "upwards": (MESH.format("../../../../etc/passwd.obj"), "is not in the folder"),
    "file url": (MESH.format("file:///etc/hosts.stl"), "is not in the folder"),
    "dae": (MESH.format("a.dae"), "obj or .stl"),
    "missing": (MESH.format("a.obj"), "is not in the folder"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_urdf_files_that_are_none_are_refused(tmp_path: Path, name: str) -> None:
    """Each with what is wrong."""
    text, why = TEXTS[name]
    (tmp_path / "a.obj.txt").write_text("x")
    if "scale" in name:
        (tmp_path / "a.obj").write_bytes(obj(angle()))
    with pytest.raises(RlbenchPinError, match=why):
        make("a.urdf", text, tmp_path)


def _flat(turned: bool) -> bytes:
    mesh = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])
    if turned:
        mesh.apply_transform(trimesh.transformations.euler_matrix(0.7, 0.4, 0.2))
    return obj(mesh)


def _lying_stl(count: int) -> bytes:
    return bytes(80) + struct.pack("<I", count) + bytes(50)


MESHES = {
    "nan.stl": (bytes(80) + struct.pack("<I", 1) + struct.pack("<12f", *[np.nan] * 12) + b"\0\0", "number"),
    "inf.obj": (b"v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "number"),
    "lie.stl": (_lying_stl(1000), "declares 1000 triangles, and has 1"),
    "lies.stl": (_lying_stl(2**32 - 1), "faces"),
    "flat.obj": (_flat(False), "flat"),
    "tilted.obj": (_flat(True), "flat"),
    "dot.obj": (b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "too small|no triangles"),
    "line.obj": (b"v 0 0 0\nv 0.1 0 0\nv 0.2 0 0\nf 1 2 3\n", "flat|no triangles"),
    "far.obj": (b"v 1e5 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n", "the limit is 2 m"),
    "noise.stl": (bytes(range(256)) * 40, "noise.stl"),
    "deflated.obj": (b"f 1/2/3 9999999999999999999999 -7\n" * 9, "deflated.obj"),
    "name.gltf": (b"{}", "obj, .stl, .urdf or .zip"),
    "noending": (b"v 0 0 0\n", "obj, .stl"),
}


@pytest.mark.parametrize("name", MESHES)
def test_meshes_that_are_none_are_refused(tmp_path: Path, name: str) -> None:
    """Each with what is wrong."""
    data, why = MESHES[name]
    with pytest.raises(RlbenchPinError, match=why):
        make(name, data, tmp_path, mass=1.0)


def test_materials_of_a_mesh_are_not_read(tmp_path: Path) -> None:
    """Neither by a path upwards, nor absolute, nor by lines that go on."""
    head = b"mtllib ../../../etc/passwd\nmtllib /etc/shadow \\\n /etc/hosts\nusemtl ../x\nmap_Kd /etc/hosts\n"
    asset = make("a.obj", head + obj(angle()), tmp_path, mass=1.0)
    assert all(b"mtl" not in content for content in asset.files.values())


@pytest.mark.parametrize(
    "name", ["../../pick.obj", "/etc/passwd.obj", "C:\\x\\pick.obj", "a b\n.obj", "pick_and_lift.py.obj", ".hidden.obj", "é" * 90]
)
def test_names_become_plain(tmp_path: Path, name: str) -> None:
    """Letters, digits and `_`; nothing is written elsewhere."""
    asset = make(f"{name}.obj", obj(angle()), tmp_path, mass=1.0)
    assert all(file.rpartition(".")[0].replace("_", "a").isalnum() for file in asset.files)
    put(asset, tmp_path / "made")


# Archives ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["../a.urdf", "/a.urdf", "x/../../a.urdf", "..\\a.urdf", "C:/a.urdf", "a\n.urdf"])
def test_paths_out_of_an_archive_are_refused(path: str) -> None:
    """Even though nothing is unpacked by its path."""
    with pytest.raises(UploadRefused, match="outside of it"):
        read_archive("a.zip", zipped({path: "x", "b.urdf": "x"}), (".urdf",))


def test_links_and_locks_in_an_archive_are_refused() -> None:
    """A link would be a way out."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        link = zipfile.ZipInfo("a.obj")
        link.external_attr = 0o120777 << 16
        archive.writestr(link, "/etc/passwd")
    with pytest.raises(UploadRefused, match="is a link"):
        read_archive("a.zip", stream.getvalue(), (".obj",))
    locked = bytearray(zipped({"a.obj": "x"}))
    locked[locked.rindex(b"PK\x01\x02") + 8] |= 1
    with pytest.raises(UploadRefused, match="password"):
        read_archive("a.zip", bytes(locked), (".obj",))


@pytest.mark.simulation
def test_bombs_are_refused() -> None:
    """By what they say, by what they hold, and by their number."""
    with pytest.raises(UploadRefused, match="too large|more than"):
        read_archive("a.zip", zipped({"a.obj": bytes(80 * 2**20)}), (".obj",))
    with pytest.raises(UploadRefused, match="more than"):
        read_archive("a.zip", zipped({f"{k}.obj": bytes(60 * 2**20) for k in range(5)}), (".obj",))
    with pytest.raises(UploadRefused, match="3000 files"):
        read_archive("a.zip", zipped({f"{k}.txt": "" for k in range(3000)}), (".obj",))
    lying = bytearray(zipped({"a.obj": bytes(2**20)}))
    where = lying.rindex(b"PK\x01\x02")
    lying[where + 24 : where + 28] = struct.pack("<I", 10)
    with pytest.raises(UploadRefused):
        read_archive("a.zip", bytes(lying), (".obj",))


@pytest.mark.parametrize("seed", range(40))
def test_broken_archives_are_refused_or_read(seed: int) -> None:
    """Bytes that were changed at random."""
    rng = np.random.default_rng(seed)
    data = np.frombuffer(zipped({"a.urdf": "<robot/>", "b/c.obj": obj(angle())}), np.uint8).copy()
    data[rng.integers(0, len(data), 20)] = rng.integers(0, 256, 20)
    try:
        read_archive("a.zip", data.tobytes()[: int(rng.integers(len(data) // 2, len(data)))], (".urdf", ".obj"))
    except UploadRefused as error:
        assert "a.zip" in str(error)


@pytest.mark.parametrize("seed", range(60))
def test_broken_meshes_are_refused_or_read(seed: int) -> None:
    """Bytes that were changed at random; what is read has finite corners."""
    rng = np.random.default_rng(seed)
    name, content = [("a.stl", stl(angle())), ("a.obj", obj(angle()))][seed % 2]
    data = np.frombuffer(content, np.uint8).copy()
    places = rng.integers(0, len(data), 6)
    data[places] = rng.integers(0, 256, 6) if seed % 2 == 0 else rng.choice(np.frombuffer(b"0123456789.-e \nfv/", np.uint8), 6)
    try:
        mesh = read_mesh(name, data.tobytes()).mesh
    except UploadRefused as error:
        assert name in str(error)
    else:
        assert np.isfinite(mesh.vertices).all()
        assert len(mesh.faces)
