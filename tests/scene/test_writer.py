"""Writing scene files: nothing is lost, least of all comments."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import SceneFileError, StorageError
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.scene.spec import ArcSpec, FrameSpec, HistorySpec, SceneSpec, WaypointSpec
from rlbench_pin.scene.writer import write_scene
from rlbench_pin.tasks import LIBRARY

SCENES = sorted(LIBRARY.glob("*.toml"))


def dump(scene: SceneSpec) -> dict[str, object]:
    """Return a scene as plain values with numbers to 1e-8."""

    def plain(value: object) -> object:
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items()}
        if isinstance(value, tuple | list):
            return [plain(v) for v in value]
        return round(value, 8) + 0.0 if isinstance(value, float) else value

    return plain(scene.model_dump())  # type: ignore[return-value]


def alike(a: object, b: object) -> bool:
    """Whether two dumps agree, numbers within the 1e-9 that a file is rounded to."""
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(alike(a[key], b[key]) for key in a)
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(map(alike, a, b))
    return a == pytest.approx(b, abs=2e-9, rel=0.0) if isinstance(a, float) and isinstance(b, float) else a == b


@pytest.mark.parametrize("file", SCENES, ids=lambda f: f.stem)
def test_a_new_file_says_the_same(tmp_path: Path, file: Path) -> None:
    """Reading what was written gives the scene back."""
    scene = read_scene(file)
    write_scene(scene, tmp_path / "scene.toml")
    assert alike(read_scene(tmp_path / "scene.toml").model_dump(), scene.model_dump())


@pytest.mark.parametrize("file", SCENES, ids=lambda f: f.stem)
def test_writing_an_unchanged_scene_changes_no_byte(tmp_path: Path, file: Path) -> None:
    """Comments, order and layout survive; also where tables come from another scene."""
    copy, scene = tmp_path / file.name, read_scene(file)
    for name in (file.name, *([f"{scene.base}.toml"] if scene.base else [])):
        shutil.copy(LIBRARY / name, tmp_path)
    write_scene(scene, copy)
    assert copy.read_text() == file.read_text()


def test_a_scene_with_a_base_is_not_changed(tmp_path: Path) -> None:
    """What it takes from another scene has no place in its file; a new file has all of it."""
    for name in ("open_drawer2", "open_drawer"):
        shutil.copy(LIBRARY / f"{name}.toml", tmp_path)
    file, new = tmp_path / "open_drawer2.toml", tmp_path / "new.toml"
    scene = read_scene(file)
    changed = scene.model_copy(update={"waypoint": scene.waypoint[:2]})
    with pytest.raises(SceneFileError, match=r"key 'base'.*Write a new file\."):
        write_scene(changed, file)
    assert file.read_text() == (LIBRARY / file.name).read_text()
    write_scene(changed, new)
    assert alike(read_scene(new).model_dump(), changed.model_dump())


def test_a_history_is_written(tmp_path: Path) -> None:
    """A new entry goes to the end, and the file keeps its other bytes; a history without changes is left alone."""
    file = tmp_path / "open_drawer.toml"
    shutil.copy(LIBRARY / file.name, file)
    entries = tuple(HistorySpec(version=v, change="The drawer is heavier.") for v in (2, 3))
    write_scene(read_scene(file).model_copy(update={"history": entries[:1]}), file)
    before = file.read_text()
    assert before.startswith((LIBRARY / file.name).read_text().rstrip("\n")) and read_scene(file).version == 2
    write_scene(read_scene(file), file)
    assert file.read_text() == before
    write_scene(read_scene(file).model_copy(update={"history": entries}), file)
    assert file.read_text().startswith(before) and read_scene(file).history == entries


def test_only_what_changed_is_rewritten(tmp_path: Path) -> None:
    """A moved waypoint keeps its comment; a removed frame goes; a new one comes last in its table."""
    file = tmp_path / "open_drawer.toml"
    shutil.copy(LIBRARY / file.name, file)
    scene = read_scene(file)
    moved = scene.waypoint[1].model_copy(update={"pose": (0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0)})
    new = FrameSpec(name="new", parent="chest", pose=(0.0, 0.0, 0.1, 0.0, 0.0, np.sin(0.25), np.cos(0.25)))
    changed = scene.model_copy(
        update={"waypoint": (scene.waypoint[0], moved, scene.waypoint[2]), "frame": (*scene.frame[1:], new)}
    )
    write_scene(changed, file)
    text = file.read_text()
    assert dump(read_scene(file)) == dump(changed)
    assert "pose = [0.1, 0.2, 0.3]" in text
    assert "# moves to the handle of the requested drawer" in text
    assert "handle_bottom" not in text
    assert '\n\n[[frame]]\nname = "new"\nparent = "chest"\npose = [0.0, 0.0, 0.1, 0.5]\n\n[[waypoint]]' in text


def test_curves_and_springs_are_written(tmp_path: Path) -> None:
    """Nested records become inline tables without their defaults."""
    arc = WaypointSpec(name="waypoint0", path="curve", arc=ArcSpec(axis=(0.0, 0.0, 1.0), angle=0.5))
    points = WaypointSpec(name="waypoint1", path="curve", points=((0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),))
    write_scene(SceneSpec(format=1, waypoint=(arc, points)), tmp_path / "scene.toml")
    assert "arc = {axis = [0.0, 0.0, 1.0], angle = 0.5}" in (tmp_path / "scene.toml").read_text()
    assert read_scene(tmp_path / "scene.toml").waypoint == (arc, points)


def test_an_emptied_table_disappears(tmp_path: Path) -> None:
    """Removing the last frame removes its heading."""
    file = tmp_path / "scene.toml"
    file.write_text('format = 1 # mine\n\n[[frame]]\nname = "a"\n')
    write_scene(SceneSpec(format=1), file)
    assert "frame" not in file.read_text()
    assert "# mine" in file.read_text()


def test_what_cannot_be_written_is_an_error_of_ours_and_leaves_nothing_behind(tmp_path: Path) -> None:
    """A folder of that name, a folder that is missing, a file that is no TOML and stays as it is, one that is no text."""
    spec = SceneSpec(format=2)
    (tmp_path / "folder.toml").mkdir()
    for path in (tmp_path / "folder.toml", tmp_path / "gone" / "scene.toml"):
        with pytest.raises(StorageError, match="cannot be written"):
            write_scene(spec, path)
    for content in (b"[[body", b"\xff\xfe"):
        (tmp_path / "broken.toml").write_bytes(content)
        with pytest.raises(SceneFileError, match=r"broken.toml: file: it is not valid TOML.*Mend it"):
            write_scene(spec, tmp_path / "broken.toml")
        assert (tmp_path / "broken.toml").read_bytes() == content
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken.toml", "folder.toml"]
