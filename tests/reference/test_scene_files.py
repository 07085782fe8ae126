"""The page about scene files has every key, and the reader takes them."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from reference_lib import scene_files

from rlbench_pin.errors import SceneFileError
from rlbench_pin.scene import read_scene
from rlbench_pin.tasks import library_names, task_class
from tests.reference.support import page, part, rows

POSED = {
    "body": 'asset = "objects/cube/cube.urdf"',
    "frame": "",
    "region": "size = [1, 1, 0]",
    "sensor": 'shape = "sphere"\nsize = [1]',
    "waypoint": "",
}
"""Tables of things with a place, and what an entry needs beside its name."""
COMMON = {
    "name": "",
    "parent": 'parent = "world"',
    "pose": "pose = [0, 0, 1]",
    "rpy": "rpy = [0, 0, 1]",
    "poses": "poses = [[0, 0, 1]]",
}
"""The keys that they share, and how one is written."""


def keys_on_the_page() -> dict[str, set[str]]:
    """Return table -> its keys, by the page."""
    common = {row[0] for row in rows(part("scene_files", "posed"))}
    found = {table: {row[0] for row in rows(part("scene_files", table.replace(".", "-")))} for table in scene_files.tables()}
    for table in POSED:
        found[table] |= common - {"poses"} if table == "waypoint" else common
    return found


def keys_used(content: dict[str, object]) -> dict[str, set[str]]:
    """Return table -> the keys that a scene file uses in it; tables inside tables count as their own."""
    used: dict[str, set[str]] = {}
    for table, entries in content.items():
        for entry in entries if isinstance(entries, list) else [entries] if isinstance(entries, dict) else []:
            used.setdefault(table, set()).update(entry)
            for key, value in entry.items():
                if isinstance(value, dict):
                    used.setdefault(f"{table}.{key}", set()).update(value)
    return used


def example() -> str:
    """Return the scene file of the page, of which each block is a piece."""
    return "\n".join(re.findall(r"```toml\n(.*?)```", page("scene_files"), re.DOTALL))


@pytest.mark.parametrize("name", library_names())
def test_the_page_has_every_key_of_the_library(name: str) -> None:
    """No scene says anything that the page does not explain."""
    used = keys_used(tomllib.loads(task_class(name).scene_file().read_text(encoding="utf-8")))
    known = keys_on_the_page()
    assert {table: keys - known[table] for table, keys in used.items() if keys - known[table]} == {}


def test_the_reader_takes_every_key_of_the_page(tmp_path: Path) -> None:
    """The examples of the page, together a scene file, use all but those that everything with a place has; those come after."""
    file = tmp_path / "scene.toml"
    file.write_text(example(), encoding="utf-8")
    assert len(read_scene(file).waypoint) == 5
    used, known = keys_used(tomllib.loads(example())), keys_on_the_page()
    assert {table: keys - used[table] - set(COMMON) for table, keys in known.items()} == dict.fromkeys(known, set())
    for table, needed in POSED.items():
        for key in known[table] & set(COMMON):
            file.write_text(f'format = 2\n[[{table}]]\nname = "{table}0"\n{needed}\n{COMMON[key]}\n', encoding="utf-8")
            assert len(getattr(read_scene(file), table)) == 1, (table, key)


@pytest.mark.parametrize("key", ["shape", "poses"])
def test_the_reader_takes_no_other_key(tmp_path: Path, key: str) -> None:
    """One of another table, and an array of waypoints."""
    file = tmp_path / "scene.toml"
    file.write_text(f'format = 2\n[[waypoint]]\nname = "waypoint0"\n{key} = []\n', encoding="utf-8")
    with pytest.raises(SceneFileError, match=key):
        read_scene(file)
