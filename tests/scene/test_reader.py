"""Scene files: what is read, and what is said about each mistake."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import AssetInvalid, AssetNotFound, SceneFileError
from rlbench_pin.scene import SceneSpec, read_scene, read_scene_text, resolve_asset
from rlbench_pin.scene.reader import raw_scene, scene_from_raw
from rlbench_pin.scene.spec import FrameSpec, PlacementSpec
from rlbench_pin.scene.writer import write_scene
from rlbench_pin.spatial import TABLE_HEIGHT, euler_to_quaternion
from rlbench_pin.tasks import LIBRARY

CUBE = 'asset = "objects/cube/cube.urdf"'
CHEST = '[[body]]\nname = "chest"\nasset = "objects/chest/chest.urdf"\n'
HISTORY = '[[history]]\nversion = {}\nchange = "The handle is found at a new place."\n'
DEVIATION = '[[deviation]]\nname = "yaw"\nspecified = "0"\nhere = "1"\nreason = "because"\n'

MISTAKES = {
    "no format": ("", "key 'format'", "format = 2"),
    "wrong format number": ("format = 3", "key 'format'", "3 is not supported. This version reads the formats 1 to 2"),
    "base that is not there": ('format = 2\nbase = "open_drawr"', "key 'base'", "there is no scene 'open_drawr' in the same"),
    "base that is no name": ("format = 2\nbase = []", "key 'base'", "there is no scene '[]' in the same folder"),
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
    "history that begins with 1": (f"format = 2\n{HISTORY.format(1)}", "[[history]]", "greater than or equal to 2"),
    "history with a gap": (
        f"format = 2\n{HISTORY.format(2)}{HISTORY.format(4)}",
        "[[history]], key 'version'",
        "version 4 is in the place of version 3. Number the entries 2, 3, ... in their order.",
    ),
    "history out of order": (
        f"format = 2\n{HISTORY.format(3)}{HISTORY.format(2)}",
        "[[history]], key 'version'",
        "place of version 2",
    ),
    "history without a change": ("format = 2\n[[history]]\nversion = 2", "[[history]]", "'change' is missing"),
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


ROW = """format = 2

[[frame]]
name = "before"

[[body]]
name = "man3"                               # to man5
asset = "objects/cube/cube.urdf"
poses = [[0.0, 0.1, 0.02], [0.1, 0.1, 0.02], [0.2, 0.1, 0.02]]
rpy = [0.0, 0.0, 1.5707963]

[[body]]
name = "king"
asset = "objects/cube/cube.urdf"

[[sensor]]
name = "square0"
parent = "king"
poses = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0, 0.5]]
shape = "sphere"
size = [0.1]
"""

MISTAKES_short_forms = {
    "unnumbered array": ('[[frame]]\nname = "man"\nposes = [[0, 0, 0]]', "[[frame]] 'man', key 'name'", "'piece0'"),
    "padded array": ('[[frame]]\nname = "man00"\nposes = [[0, 0, 0]]', "[[frame]] 'man00', key 'name'", "numbered name"),
    "pose and poses": ('[[frame]]\nname = "a0"\npose = [0, 0, 0]\nposes = [[0, 0, 0]]', "key 'poses'", "Leave one of them out"),
    "no poses": ('[[frame]]\nname = "a0"\nposes = []', "[[frame]] 'a0', key 'poses'", "one for each element"),
    "flat poses": ('[[frame]]\nname = "a0"\nposes = [0, 0, 0]', "[[frame]] 'a0', key 'poses'", "[[x, y, z], ...]"),
    "bad pose in an array": ('[[frame]]\nname = "a0"\nposes = [[0, 0, 0], [0, 0]]', "[[frame]] 'a1', key 'pose'", "not 2"),
    "array of waypoints": (
        '[[waypoint]]\nname = "waypoint0"\nposes = [[0, 0, 0]]',
        "'poses' is not known",
        "Did you mean 'pose'?",
    ),
    "misspelt poses": ('[[body]]\nname = "a0"\nposses = [[0, 0, 0]]', "key 'posses'", "Did you mean 'poses'?"),
    "two rotations": (
        '[[frame]]\nname = "a"\npose = [0, 0, 0, 1]\nrpy = [0, 0, 0]',
        "[[frame]] 'a', key 'rpy'",
        "pose [x, y, z]",
    ),
    "two angles": ('[[frame]]\nname = "a"\nrpy = [0, 0]', "[[frame]] 'a', key 'rpy'", "three angles"),
    "same name in and beside an array": (
        '[[frame]]\nname = "a0"\nposes = [[0, 0, 0], [1, 0, 0]]\n[[frame]]\nname = "a1"',
        "'a1'",
        "twice",
    ),
}


def written_short_forms(folder: Path, text: str) -> Path:
    """Write a scene file and return where."""
    file = folder / "scene.toml"
    file.write_text(text)
    return file


@pytest.mark.parametrize(("text", "where", "advice"), MISTAKES_short_forms.values(), ids=MISTAKES_short_forms.keys())
def test_a_mistake_is_named_with_its_place_and_remedy(tmp_path: Path, text: str, where: str, advice: str) -> None:
    """As for every other key."""
    with pytest.raises(SceneFileError) as caught:
        read_scene(written_short_forms(tmp_path, f"format = 2\n{text}"))
    assert where in str(caught.value)
    assert advice in str(caught.value)


@pytest.mark.parametrize("key", ["rpy = [0, 0, 0]", "poses = [[0, 0, 0]]"])
def test_a_file_of_format_1_has_no_short_forms(tmp_path: Path, key: str) -> None:
    """The message says from which format on they are known."""
    with pytest.raises(SceneFileError, match="known from `format = 2` on"):
        read_scene(written_short_forms(tmp_path, f'format = 1\n[[frame]]\nname = "a0"\n{key}'))


@pytest.mark.parametrize(
    ("number", "z", "height"), [(1, 0.752, 0.752), (2, 0.0, TABLE_HEIGHT), (2, 0.1, round(TABLE_HEIGHT + 0.1, 12))]
)
def test_heights_of_format_2_count_from_the_table_top(tmp_path: Path, number: int, z: float, height: float) -> None:
    """Those of format 1 from the floor; the records hold the height in the world."""
    scene = read_scene(written_short_forms(tmp_path, f"format = {number}\n[placement]\npose = [0.1, 0.2, {z}, 0.5]"))
    assert scene.placement.pose[:3] == (0.1, 0.2, height)
    assert scene.format == number
    default = read_scene(written_short_forms(tmp_path, f"format = {number}\n[placement]\nstatic = true"))
    assert default.placement == PlacementSpec(static=True)


def test_rpy_is_the_rotation_of_spatial(tmp_path: Path) -> None:
    """Right angles with seven digits give exact quaternions; waypoints have it too."""
    text = (
        'format = 2\n[[frame]]\nname = "down"\npose = [0.1, 0, 0]\nrpy = [3.1415927, 0, 0]\n'
        '[[frame]]\nname = "a"\nrpy = [0.1, -0.2, 0.3]\n[[waypoint]]\nname = "waypoint0"\nrpy = [0, 1.5707963, 0]\n'
    )
    scene = read_scene(written_short_forms(tmp_path, text))
    assert scene.frame[0].pose == (0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(scene.frame[1].pose[3:], euler_to_quaternion(0.1, -0.2, 0.3), atol=1e-7)
    half = FrameSpec(name="a", pose=(0.0, 0.0, 0.0, 0.0, 0.7071068, 0.0, 0.7071068))
    assert scene.waypoint[0].pose == half.pose


def test_an_array_counts_on_from_the_name_of_its_first_thing(tmp_path: Path) -> None:
    """Its things stand where the array stood, in its order, and share everything but the pose."""
    scene = read_scene(written_short_forms(tmp_path, ROW))
    assert [body.name for body in scene.body] == ["man3", "man4", "man5", "king"]
    assert [body.pose[0] for body in scene.body] == [0.0, 0.1, 0.2, 0.0]
    assert len({body.pose[1:] for body in scene.body[:3]}) == 1
    assert scene.body[1].pose[3:] == pytest.approx([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])
    assert [(s.name, s.parent, s.size) for s in scene.sensor] == [("square0", "king", (0.1,)), ("square1", "king", (0.1,))]


def test_an_array_in_which_nothing_changed_stays_one(tmp_path: Path) -> None:
    """Other entries of its table may change."""
    file = written_short_forms(tmp_path, ROW)
    scene = read_scene(file)
    write_scene(scene, file)
    assert file.read_text() == ROW
    king = scene.body[3].model_copy(update={"scale": 2.0})
    write_scene(scene.model_copy(update={"body": (*scene.body[:3], king)}), file)
    assert "scale = 2.0" in file.read_text()
    assert "to man5" in file.read_text()


def test_an_array_in_which_something_changed_is_written_out(tmp_path: Path) -> None:
    """In its place, thing by thing; one that is gone is left out; the other array stays."""
    file = written_short_forms(tmp_path, ROW)
    scene = read_scene(file)
    moved = scene.body[1].model_copy(update={"pose": (0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)})
    changed = scene.model_copy(update={"body": (scene.body[0], moved, scene.body[3])})
    write_scene(changed, file)
    text = file.read_text()
    assert [body.name for body in read_scene(file).body] == ["man3", "man4", "king"]
    assert read_scene(file).body[1] == moved
    np.testing.assert_allclose(read_scene(file).body[0].pose, scene.body[0].pose, atol=1e-8)
    written_out = (
        '"before"\n\n[[body]]\nname = "man3"\npose = [0.0, 0.1, 0.02, 1.570796327]\nasset = "objects/cube/cube.urdf"\n\n'
    )
    assert f'{written_out}[[body]]\nname = "man4"\npose = [0.5, 0.0, 0.0]\nasset = "objects/cube/cube.urdf"\n\n[[body]]' in text
    assert "poses = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0, 0.5]]" in text


def test_a_rotation_that_changed_is_written_as_a_pose(tmp_path: Path) -> None:
    """Where it did not, `rpy` stays as it was written_short_forms."""
    file = written_short_forms(tmp_path, 'format = 2\n\n[[frame]]\nname = "a"\nrpy = [3.1415927, 0.0, 0.0]\n')
    scene = read_scene(file)
    write_scene(scene, file)
    assert "rpy = [3.1415927, 0.0, 0.0]" in file.read_text()
    turned = scene.frame[0].model_copy(update={"pose": (0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0)})
    write_scene(scene.model_copy(update={"frame": (turned,)}), file)
    assert "rpy" not in file.read_text()
    assert read_scene(file).frame[0] == turned


@pytest.mark.parametrize("number", [1, 2])
def test_a_file_keeps_its_format(tmp_path: Path, number: int) -> None:
    """The height of a moved root is written_short_forms as that format means it."""
    file = written_short_forms(tmp_path, f"format = {number}\n")
    placed = PlacementSpec(pose=(0.3, 0.0, TABLE_HEIGHT + 0.05, 0.0, 0.0, 0.0, 1.0))
    write_scene(SceneSpec(format=2, placement=placed), file)
    assert f"format = {number}\n" in file.read_text()
    assert f"pose = [0.3, 0.0, {round(TABLE_HEIGHT + 0.05, 9) if number == 1 else 0.05}]" in file.read_text()
    assert read_scene(file).placement == placed


BASE = f"""format = 2
[placement]
pose = [0.4, 0.0, 0.0]
yaw = [-0.1, 0.1]
[[body]]
name = "piece0"
{CUBE}
poses = [[0.0, 0.0, 0.1], [0.1, 0.0, 0.1]]
[[frame]]
name = "above"
rpy = [0.0, 0.0, 1.5707963]
{DEVIATION}"""


def test_a_scene_replaces_tables_of_its_base_by_name(tmp_path: Path) -> None:
    """Entries stay in the order of the base, new ones follow; unnamed keys of `[placement]` stay; deviations are its own."""
    (tmp_path / "first.toml").write_text(BASE)
    body = '[[body]]\nname = "piece0"\nasset = "objects/cube_45/cube_45.urdf"\npose = [0.0, 0.0, 0.2]\n'
    rest = '[placement]\nyaw = [-0.2, 0.2]\n[[frame]]\nname = "below"\n'
    (tmp_path / "second.toml").write_text(f'format = 2\nbase = "first"\n{body}{rest}')
    base, scene = read_scene(tmp_path / "first.toml"), read_scene(tmp_path / "second.toml")
    assert [(b.name, b.asset.split("/")[1], b.pose[2]) for b in scene.body] == [
        ("piece0", "cube_45", 0.2),
        ("piece1", "cube", 0.1),
    ]
    assert scene.frame[0] == base.frame[0] and scene.frame[1].name == "below"
    assert scene.placement.yaw == (-0.2, 0.2) and scene.placement.pose == base.placement.pose
    assert len(base.deviation) == 1 and scene.deviation == ()


def test_the_version_follows_from_the_history(tmp_path: Path) -> None:
    """Version 1 without entries, else that of the last entry; a scene with a base has a history of its own."""
    first = tmp_path / "first.toml"
    first.write_text(BASE)
    assert read_scene(first).version == 1
    first.write_text(BASE + HISTORY.format(2) + HISTORY.format(3) + 'release = "0.2.0"\n')
    scene = read_scene(first)
    assert scene.version == 3 and scene.history[1].release == "0.2.0" and scene.history[0].release is None
    (tmp_path / "second.toml").write_text('format = 2\nbase = "first"\n')
    assert read_scene(tmp_path / "second.toml").version == 1
    (tmp_path / "second.toml").write_text('format = 2\nbase = "first"\n' + HISTORY.format(2))
    assert read_scene(tmp_path / "second.toml").version == 2


def test_a_base_has_no_base_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "first.toml").write_text(BASE)
    (tmp_path / "second.toml").write_text('format = 2\nbase = "first"\n')
    (tmp_path / "third.toml").write_text('format = 2\nbase = "second"\n')
    with pytest.raises(SceneFileError, match="'second.toml' has a base itself"):
        read_scene(tmp_path / "third.toml")


def test_a_new_file_has_format_2(tmp_path: Path) -> None:
    """Whatever the scene was read from."""
    write_scene(SceneSpec(format=1), tmp_path / "new.toml")
    assert read_scene(tmp_path / "new.toml").format == 2


ARC = '[[waypoint]]\nname = "waypoint0"\npath = "curve"\narc = {{ axis = {axis}, angle = {angle} }}\n'
BODY = '[[body]]\nname = "cube"\nasset = "objects/cube_small/cube_small.urdf"\n'


def read(tmp_path: Path, content: str) -> SceneSpec:
    """Read a file of format 2."""
    (tmp_path / "scene.toml").write_text(f"format = 2\n{content}", encoding="utf-8")
    return read_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("angle", ["90", "-90.0", "1e20", "7.0"])
def test_angles_in_degrees_are_recognised(tmp_path: Path, angle: str) -> None:
    """At once, with the angle in radians."""
    began = time.monotonic()
    with pytest.raises(SceneFileError, match=r"'waypoint0', key 'arc.angle': .*at most 2 pi.*degrees") as caught:
        read(tmp_path, ARC.format(axis="[0, 0, 1]", angle=angle))
    assert time.monotonic() - began < 2.0
    if angle == "90":
        assert "90 degrees are 1.5708 rad" in str(caught.value)


def test_a_full_turn_is_an_angle(tmp_path: Path) -> None:
    """6.2832 is one turn."""
    (waypoint,) = read(tmp_path, ARC.format(axis="[0, 0, 1]", angle="6.283185")).waypoint
    assert waypoint.arc is not None
    assert waypoint.arc.angle == 6.283185


@pytest.mark.parametrize(
    ("content", "key"),
    [
        (ARC.format(axis="[0, 0, 0]", angle="1"), "arc.axis"),
        (ARC.format(axis="[0, 0, 1]", angle="true"), "arc.angle"),
        (ARC.format(axis="[0, 0, 1]", angle='"1"'), "arc.angle"),
        (BODY + "pose = [true, 0, 0]", "pose"),
        (BODY + 'pose = ["0", "0", "0"]', "pose"),
        (BODY + "pose = [1e9, 0, 0]", "pose"),
        (BODY + "pose = [0, 0, 0, 90.0]", "pose"),
        (BODY + "pose = [0, 0, 0, 0, 0, 0, 0]", "pose"),
        (BODY + "rpy = [180.0, 0, 0]", "rpy"),
        (BODY + "rpy = [true, 0, 0]", "rpy"),
        (BODY + 'fixed = "yes"', "fixed"),
        (BODY + "fixed = 1", "fixed"),
        (BODY + "scale = true", "scale"),
        (BODY + "scale = 1e20", "scale"),
        (BODY + "color = [200, 0, 0]", "color"),
        ('[[waypoint]]\nname = "waypoint0"\nsymmetry = true', "symmetry"),
        ('[[waypoint]]\nname = "waypoint0"\nsymmetry = "4"', "symmetry"),
        ('[[waypoint]]\nname = "waypoint0"\ngripper = true', "gripper"),
        ('[[region]]\nname = "patch"\nsize = [1e300, 1, 0]', "size"),
        ('[[sensor]]\nname = "eye"\nshape = "sphere"\nsize = [true]', "size"),
        ("[placement]\nyaw = [-180, 180]", "yaw"),
        ("[placement]\nfootprint = [-1.0, 1.0]", "footprint"),
        ('[placement]\nstatic = "no"', "static"),
    ],
)
def test_what_is_no_number_of_its_kind_is_refused(tmp_path: Path, content: str, key: str) -> None:
    """Truth values and text are not read as numbers, numbers not as switches; lengths and angles have bounds."""
    with pytest.raises(SceneFileError, match=key):
        read(tmp_path, content)


@pytest.mark.parametrize("number", ["true", "1.0", '"2"', "1979-05-27"])
def test_the_format_is_a_whole_number(tmp_path: Path, number: str) -> None:
    """`true` is not format 1."""
    (tmp_path / "scene.toml").write_text(f"format = {number}\n", encoding="utf-8")
    with pytest.raises(SceneFileError, match="key 'format'"):
        read_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize(
    "content",
    [
        "a = " + "[" * 100_000,
        "a = " + "9" * 6000,
        '[[frame]]\nname = "a' + "9" * 6000 + '"\nposes = [[0, 0, 0]]',
        '[[frame]]\nname = "a0"\nposes = [' + "[0, 0, 0]," * 2000 + "]",
        "".join(f'[[waypoint]]\nname = "waypoint{i}"\n' for i in range(300)),
    ],
)
def test_endless_files_are_refused(tmp_path: Path, content: str) -> None:
    """Too deep, too many digits, too many things: typed, and at once."""
    with pytest.raises(SceneFileError):
        read(tmp_path, content)
