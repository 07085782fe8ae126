"""Scene files: what is read, and what is said about each mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import AssetInvalid, AssetNotFound, SceneFileError
from rlbench_pin.scene import SceneSpec, read_scene, read_scene_text, resolve_asset
from rlbench_pin.scene.reader import raw_scene, scene_from_raw
from rlbench_pin.tasks import LIBRARY

CUBE = 'asset = "objects/cube/cube.urdf"'
CHEST = '[[body]]\nname = "chest"\nasset = "objects/chest/chest.urdf"\n'
DEVIATION = '[[deviation]]\nname = "yaw"\nspecified = "0"\nhere = "1"\nreason = "because"\n'

MISTAKES = {
    "no format": ("", "key 'format'", "format = 2"),
    "wrong format number": ("format = 3", "key 'format'", "3 is not supported. This version reads the formats 1 to 2"),
    "no TOML": ("format = = 1", "file", "not valid TOML"),
    "misspelt table": ('format = 1\n[[waypoints]]\nname = "waypoint0"', "key 'waypoints'", "Did you mean 'waypoint'?"),
    "misspelt key": (
        'format = 1\n[[waypoint]]\nname = "waypoint0"\ngriper = "open"',
        "[[waypoint]] 'waypoint0', key 'griper'",
        "Did you mean 'gripper'?",
    ),
    "misspelt key of a required one": (f'format = 1\n[[body]]\nnam = "a"\n{CUBE}', "[[body]] 'number 0'", "Did you mean 'name'?"),
    "misspelt key inside": (
        'format = 1\n[[waypoint]]\nname = "waypoint0"\npath = "curve"\narc = {axis = [0, 0, 1], angel = 1}',
        "key 'arc.angel'",
        "Did you mean 'angle'?",
    ),
    "misspelt placement": ("format = 1\n[placement]\nyaww = [0, 1]", "[placement], key 'yaww'", "Did you mean 'yaw'?"),
    "key unlike any": (
        'format = 1\n[[frame]]\nname = "a"\nqqqq = 1',
        "'qqqq' is not known here",
        "Known keys: name, parent, pose",
    ),
    "missing key": ('format = 1\n[[body]]\nname = "a"', "[[body]] 'a'", "'asset' is missing"),
    "bad name": ('format = 1\n[[frame]]\nname = "A b"', "[[frame]] 'A b', key 'name'", "a letter first"),
    "name of the room": ('format = 1\n[[frame]]\nname = "ceiling"', "[[frame]] 'ceiling'", "reserved"),
    "reserved name": ('format = 1\n[[frame]]\nname = "table"', "[[frame]] 'table'", "reserved"),
    "duplicate name": (f'format = 1\n[[body]]\nname = "a"\n{CUBE}\n[[frame]]\nname = "a"', "[[frame]] 'a'", "first in [[body]]"),
    "bad quaternion": (
        'format = 1\n[[frame]]\nname = "a"\npose = [0, 0, 0, 0, 0, 0, 2]',
        "[[frame]] 'a', key 'pose'",
        "norm 2.0",
    ),
    "short pose": ('format = 1\n[[frame]]\nname = "a"\npose = [0, 0]', "key 'pose'", "not 2"),
    "endless number": ('format = 1\n[[frame]]\nname = "a"\npose = [0, 0, inf]', "key 'pose", "finite"),
    "unknown path": ('format = 1\n[[waypoint]]\nname = "waypoint0"\npath = "linear"', "key 'path'", "'straight'"),
    "opening beyond one": ('format = 1\n[[waypoint]]\nname = "waypoint0"\ngripper = 1.5', "key 'gripper'", "0..1"),
    "waypoint gap": (
        'format = 1\n[[waypoint]]\nname = "waypoint0"\n[[waypoint]]\nname = "waypoint2"',
        "[[waypoint]]",
        "'waypoint1'",
    ),
    "waypoint name": ('format = 1\n[[waypoint]]\nname = "above"', "[[waypoint]] 'above'", "[[frame]]"),
    "waypoint padded": ('format = 1\n[[waypoint]]\nname = "waypoint00"', "[[waypoint]] 'waypoint00'", "its number"),
    "curve without points": ('format = 1\n[[waypoint]]\nname = "waypoint0"\npath = "curve"', "key 'path'", "'points' or 'arc'"),
    "points without curve": (
        'format = 1\n[[waypoint]]\nname = "waypoint0"\npoints = [[0, 0, 0]]',
        "key 'path'",
        'path = "curve"',
    ),
    "unknown parent": (
        f'format = 1\n[[body]]\nname = "tray"\n{CUBE}\n[[frame]]\nname = "a"\nparent = "try"',
        "[[frame]] 'a', key 'parent'",
        "Did you mean 'tray'?",
    ),
    "unknown link": (
        f'format = 1\n{CHEST}[[frame]]\nname = "a"\nparent = "chest/drawer_top"',
        "body 'chest' has no link 'drawer_top'",
        "Did you mean 'drawer_top_link'?",
    ),
    "link of a frame": (
        'format = 1\n[[frame]]\nname = "b"\n[[frame]]\nname = "a"\nparent = "b/x"',
        "[[frame]] 'a'",
        "'b' is not a body",
    ),
    "circle": (
        'format = 1\n[[frame]]\nname = "a"\nparent = "b"\n[[frame]]\nname = "b"\nparent = "a"',
        "[[frame]] 'a'",
        "a -> b -> a",
    ),
    "joint of no body": (f'format = 1\n{CHEST}[[joint]]\nname = "chst/drawer_top"', "[[joint]] 'chst/drawer_top'", "'chest'"),
    "unknown joint": (
        f'format = 1\n{CHEST}[[joint]]\nname = "chest/drawr_top"',
        "no movable joint",
        "Did you mean 'drawer_top'?",
    ),
    "joint twice": (
        f'format = 1\n{CHEST}[[joint]]\nname = "chest/drawer_top"\n[[joint]]\nname = "chest/drawer_top"',
        "[[joint]] 'chest/drawer_top'",
        "twice",
    ),
    "joint beyond its limit": (
        f'format = 1\n{CHEST}[[joint]]\nname = "chest/drawer_top"\nposition = 0.5',
        "key 'position'",
        "0.5 is outside [0.0, 0.22]",
    ),
    "sensor size": (
        'format = 1\n[[sensor]]\nname = "a"\nshape = "box"\nsize = [1, 2]',
        "[[sensor]] 'a', key 'size'",
        "3 numbers",
    ),
    "sensor size zero": ('format = 1\n[[sensor]]\nname = "a"\nshape = "sphere"\nsize = [0]', "key 'size.0'", "greater than 0"),
    "region size": ('format = 1\n[[region]]\nname = "a"\nsize = [1, 0, 0]', "[[region]] 'a', key 'size.1'", "greater than 0"),
    "deviation without reason": (
        'format = 2\n[[deviation]]\nname = "yaw"\nspecified = "0"\nhere = "1"',
        "[[deviation]] 'yaw'",
        "'reason' is missing",
    ),
    "empty deviation": (f"format = 2\n{DEVIATION}".replace("because", ""), "[[deviation]] 'yaw', key 'reason'", "1 character"),
    "misspelt deviation": (f"format = 2\n{DEVIATION}why = 1", "key 'why'", "Known keys: binding, here, name, reason, specified"),
    "deviation twice": (f"format = 2\n{DEVIATION}{DEVIATION}", "[[deviation]] 'yaw'", "twice"),
    "yaw bounds": ("format = 1\n[placement]\nyaw = [1, 0]", "[placement], key 'yaw'", "above the upper bound"),
}


def written(folder: Path, text: str) -> Path:
    """Write a scene file and return where."""
    file = folder / "scene.toml"
    file.write_text(text)
    return file


def test_older_files_name_the_deviations_otherwise(tmp_path: Path) -> None:
    """`[[departure]]` is read as `[[deviation]]`."""
    new, old = (
        read_scene(written(tmp_path, f"format = 2\n{text}")) for text in (DEVIATION, DEVIATION.replace("deviation", "departure"))
    )
    assert old == new
    assert [entry.name for entry in old.deviation] == ["yaw"]


@pytest.mark.parametrize(("text", "where", "advice"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_named_with_its_file_place_and_remedy(tmp_path: Path, text: str, where: str, advice: str) -> None:
    """The message says which file, which table, which key, and what would be right."""
    with pytest.raises(SceneFileError) as caught:
        read_scene(written(tmp_path, text))
    message = str(caught.value)
    assert message.startswith("scene.toml: ")
    assert where in message
    assert advice in message


def test_a_missing_file_proposes_its_neighbour(tmp_path: Path) -> None:
    """A misspelt file name is answered with the nearest one."""
    written(tmp_path, "format = 1")
    with pytest.raises(SceneFileError, match=r"Did you mean 'scene.toml'\?"):
        read_scene(tmp_path / "scen.toml")
    with pytest.raises(SceneFileError, match="does not exist"):
        read_scene(tmp_path / "nowhere" / "scene.toml")


def test_a_missing_asset_is_named_with_the_body_that_needs_it(tmp_path: Path) -> None:
    """Neither a URDF nor a mesh may be missing."""
    with pytest.raises(AssetNotFound, match="objects/none/none.urdf.* needed by body 'a' of scene.toml"):
        read_scene(written(tmp_path, 'format = 1\n[[body]]\nname = "a"\nasset = "objects/none/none.urdf"'))
    with pytest.raises(AssetNotFound, match="aaaa.* needed by body 'a'"):
        read_scene(written(tmp_path, f'format = 1\n[[body]]\nname = "a"\nasset = "{"a" * 5000}"'))
    urdf = '<robot name="m"><link name="m"><visual><geometry><mesh filename="m.obj"/></geometry></visual></link></robot>'
    (tmp_path / "m.urdf").write_text(urdf)
    with pytest.raises(AssetNotFound, match=r"m\.obj.* needed by \./m\.urdf, body 'a'"):
        read_scene(written(tmp_path, 'format = 1\n[[body]]\nname = "a"\nasset = "./m.urdf"'))


def test_an_asset_that_is_no_xml_is_refused(tmp_path: Path) -> None:
    """A broken URDF is found before any simulator starts."""
    (tmp_path / "m.urdf").write_text("<robot>")
    with pytest.raises(AssetInvalid, match="not valid XML"):
        read_scene(written(tmp_path, 'format = 1\n[[body]]\nname = "a"\nasset = "./m.urdf"'))


def test_an_asset_stands_below_assets_or_beside_the_scene(tmp_path: Path) -> None:
    """`./` begins at the scene file, anything else at the assets of the package."""
    assert resolve_asset(tmp_path / "scene.toml", "./own.urdf") == (tmp_path / "own.urdf").resolve()
    assert (
        resolve_asset(SceneSpec(format=1, file=str(tmp_path / "scene.toml")), "./own.urdf") == (tmp_path / "own.urdf").resolve()
    )
    assert resolve_asset(tmp_path / "scene.toml", "objects/cube/cube.urdf").is_file()


def test_poses_have_three_forms(tmp_path: Path) -> None:
    """Three numbers are a position, four add a yaw, seven are a whole pose; quaternions become unit ones everywhere."""
    scene = read_scene(
        written(
            tmp_path,
            'format = 1\n[placement]\npose = [0.1, 0.2, 0.752]\n[[frame]]\nname = "a"\npose = [1, 2, 3, 3.141592653589793]\n'
            '[[frame]]\nname = "b"\npose = [1, 2, 3, 0, 0.7071, 0, 0.7071]\n'
            '[[waypoint]]\nname = "waypoint0"\npath = "curve"\npoints = [[1, 2, 3], [0, 0, 0, 0, 0, 0, 1.0001]]',
        )
    )
    assert scene.placement.pose == (0.1, 0.2, 0.752, 0.0, 0.0, 0.0, 1.0)
    np.testing.assert_allclose(scene.frame[0].pose, [1, 2, 3, 0, 0, 1, 0], atol=1e-12)
    assert np.linalg.norm(scene.frame[1].pose[3:]) == pytest.approx(1.0, abs=1e-15)
    assert scene.waypoint[0].points[1] == (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("file", sorted(LIBRARY.glob("*.toml")), ids=lambda f: f.stem)
def test_every_scene_of_the_library_reads(file: Path) -> None:
    """All scene files are right, know where they came from, and say their units in the first line."""
    scene = read_scene(file)
    assert scene.file == str(file)
    assert "[m]" in file.read_text().splitlines()[0]


def test_a_text_is_read_as_its_file_would_be(tmp_path: Path) -> None:
    """Also one that was not written yet; errors name the file that it is meant for."""
    file = LIBRARY / "open_drawer.toml"
    text = file.read_text()
    assert read_scene_text(text, file) == scene_from_raw(raw_scene(text, file), file) == read_scene(file)
    with pytest.raises(SceneFileError, match=r"^new.toml: file: it is not valid TOML: .*\(at line 2, column 1\)"):
        read_scene_text("format = 2\n=", tmp_path / "new.toml")
    with pytest.raises(SceneFileError, match=r"^new.toml: key 'format'"):
        read_scene_text("", tmp_path / "new.toml")


def test_a_scene_is_frozen() -> None:
    """What was read is not changed by accident."""
    scene = SceneSpec(format=1)
    with pytest.raises(ValueError, match="frozen"):
        scene.format = 1  # type: ignore[misc]
