"""What format 2 says in short: heights from the table top, `rpy`, arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import SceneFileError
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.scene.spec import FrameSpec, PlacementSpec, SceneSpec
from rlbench_pin.scene.writer import write_scene
from rlbench_pin.spatial import TABLE_HEIGHT, euler_to_quaternion

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

MISTAKES = {
    "unnumbered array": ('[[frame]]\nname = "man"\nposes = [[0, 0, 0]]', "[[frame]] 'man', key 'name'", "'piece0'"),
    "padded array": ('[[frame]]\nname = "man00"\nposes = [[0, 0, 0]]', "[[frame]] 'man00', key 'name'", "numbered name"),
    "pose and poses": ('[[frame]]\nname = "a0"\npose = [0, 0, 0]\nposes = [[0, 0, 0]]', "key 'poses'", "Leave one of them out"),
    "no poses": ('[[frame]]\nname = "a0"\nposes = []', "[[frame]] 'a0', key 'poses'", "one for each thing"),
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


def written(folder: Path, text: str) -> Path:
    """Write a scene file and return where."""
    file = folder / "scene.toml"
    file.write_text(text)
    return file


@pytest.mark.parametrize(("text", "where", "advice"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_named_with_its_place_and_remedy(tmp_path: Path, text: str, where: str, advice: str) -> None:
    """As for every other key."""
    with pytest.raises(SceneFileError) as caught:
        read_scene(written(tmp_path, f"format = 2\n{text}"))
    assert where in str(caught.value)
    assert advice in str(caught.value)


@pytest.mark.parametrize("key", ["rpy = [0, 0, 0]", "poses = [[0, 0, 0]]"])
def test_a_file_of_format_1_has_no_short_forms(tmp_path: Path, key: str) -> None:
    """The message says from which format on they are known."""
    with pytest.raises(SceneFileError, match="known from `format = 2` on"):
        read_scene(written(tmp_path, f'format = 1\n[[frame]]\nname = "a0"\n{key}'))


@pytest.mark.parametrize(
    ("number", "z", "height"), [(1, 0.752, 0.752), (2, 0.0, TABLE_HEIGHT), (2, 0.1, round(TABLE_HEIGHT + 0.1, 12))]
)
def test_heights_of_format_2_count_from_the_table_top(tmp_path: Path, number: int, z: float, height: float) -> None:
    """Those of format 1 from the floor; the records hold the height in the world."""
    scene = read_scene(written(tmp_path, f"format = {number}\n[placement]\npose = [0.1, 0.2, {z}, 0.5]"))
    assert scene.placement.pose[:3] == (0.1, 0.2, height)
    assert scene.format == number
    default = read_scene(written(tmp_path, f"format = {number}\n[placement]\nstatic = true"))
    assert default.placement == PlacementSpec(static=True)


def test_rpy_is_the_rotation_of_spatial(tmp_path: Path) -> None:
    """Right angles with seven digits give exact quaternions; waypoints have it too."""
    text = (
        'format = 2\n[[frame]]\nname = "down"\npose = [0.1, 0, 0]\nrpy = [3.1415927, 0, 0]\n'
        '[[frame]]\nname = "a"\nrpy = [0.1, -0.2, 0.3]\n[[waypoint]]\nname = "waypoint0"\nrpy = [0, 1.5707963, 0]\n'
    )
    scene = read_scene(written(tmp_path, text))
    assert scene.frame[0].pose == (0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(scene.frame[1].pose[3:], euler_to_quaternion(0.1, -0.2, 0.3), atol=1e-7)
    half = FrameSpec(name="a", pose=(0.0, 0.0, 0.0, 0.0, 0.7071068, 0.0, 0.7071068))
    assert scene.waypoint[0].pose == half.pose


def test_an_array_counts_on_from_the_name_of_its_first_thing(tmp_path: Path) -> None:
    """Its things stand where the array stood, in its order, and share everything but the pose."""
    scene = read_scene(written(tmp_path, ROW))
    assert [body.name for body in scene.body] == ["man3", "man4", "man5", "king"]
    assert [body.pose[0] for body in scene.body] == [0.0, 0.1, 0.2, 0.0]
    assert len({body.pose[1:] for body in scene.body[:3]}) == 1
    assert scene.body[1].pose[3:] == pytest.approx([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])
    assert [(s.name, s.parent, s.size) for s in scene.sensor] == [("square0", "king", (0.1,)), ("square1", "king", (0.1,))]


def test_an_array_in_which_nothing_changed_stays_one(tmp_path: Path) -> None:
    """Other entries of its table may change."""
    file = written(tmp_path, ROW)
    scene = read_scene(file)
    write_scene(scene, file)
    assert file.read_text() == ROW
    king = scene.body[3].model_copy(update={"scale": 2.0})
    write_scene(scene.model_copy(update={"body": (*scene.body[:3], king)}), file)
    assert "scale = 2.0" in file.read_text()
    assert "to man5" in file.read_text()


def test_an_array_in_which_something_changed_is_written_out(tmp_path: Path) -> None:
    """In its place, thing by thing; one that is gone is left out; the other array stays."""
    file = written(tmp_path, ROW)
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
    """Where it did not, `rpy` stays as it was written."""
    file = written(tmp_path, 'format = 2\n\n[[frame]]\nname = "a"\nrpy = [3.1415927, 0.0, 0.0]\n')
    scene = read_scene(file)
    write_scene(scene, file)
    assert "rpy = [3.1415927, 0.0, 0.0]" in file.read_text()
    turned = scene.frame[0].model_copy(update={"pose": (0.0, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0)})
    write_scene(scene.model_copy(update={"frame": (turned,)}), file)
    assert "rpy" not in file.read_text()
    assert read_scene(file).frame[0] == turned


@pytest.mark.parametrize("number", [1, 2])
def test_a_file_keeps_its_format(tmp_path: Path, number: int) -> None:
    """The height of a moved root is written as that format means it."""
    file = written(tmp_path, f"format = {number}\n")
    placed = PlacementSpec(pose=(0.3, 0.0, TABLE_HEIGHT + 0.05, 0.0, 0.0, 0.0, 1.0))
    write_scene(SceneSpec(format=2, placement=placed), file)
    assert f"format = {number}\n" in file.read_text()
    assert f"pose = [0.3, 0.0, {round(TABLE_HEIGHT + 0.05, 9) if number == 1 else 0.05}]" in file.read_text()
    assert read_scene(file).placement == placed


def test_a_new_file_has_format_2(tmp_path: Path) -> None:
    """Whatever the scene was read from."""
    write_scene(SceneSpec(format=1), tmp_path / "new.toml")
    assert read_scene(tmp_path / "new.toml").format == 2
