"""Nothing that the browser names lies outside the folder of the task."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.builder.custom_assets.folder import Folder, OutsideFolder
from rlbench_pin.errors import StorageError


@pytest.mark.parametrize(
    "name",
    [
        "../x",
        "a/../../x",
        "/etc/passwd",
        "C:\\x",
        "\\\\host\\x",
        "a\\..\\..\\x",
        "",
        "  ",
        ".ssh/id",
        "a/.git/config",
        "a\0b",
        "x" * 300,
    ],
)
def test_paths_that_lead_out_are_refused(tmp_path: Path, name: str) -> None:
    """Upwards, absolute, hidden, or no name at all."""
    with pytest.raises(OutsideFolder):
        Folder(tmp_path).path(name)
    with pytest.raises(OutsideFolder):
        Folder(tmp_path).write(name, b"x")


def test_links_that_lead_out_are_refused(tmp_path: Path) -> None:
    """A link to a folder or a file elsewhere is not followed."""
    (tmp_path / "task").mkdir()
    (tmp_path / "task" / "away").symlink_to(tmp_path)
    (tmp_path / "secret").write_text("s")
    (tmp_path / "task" / "one").symlink_to(tmp_path / "secret")
    folder = Folder(tmp_path / "task")
    for name in ("away/secret", "away/new", "one"):
        with pytest.raises(OutsideFolder, match="leads out"):
            folder.write(name, b"x")
    assert (tmp_path / "secret").read_text() == "s"
    assert not (tmp_path / "new").exists()


def test_files_inside_are_written_whole(tmp_path: Path) -> None:
    """Folders on the way are made, nothing temporary stays."""
    file = Folder(tmp_path).write("meshes/handle.obj", b"v 0 0 0\n")
    assert file.read_bytes() == b"v 0 0 0\n"
    assert [path.name for path in file.parent.iterdir()] == ["handle.obj"]


def test_what_cannot_be_written_is_an_error_of_its_own(tmp_path: Path) -> None:
    """Nothing temporary stays, neither of a file nor of a folder."""
    folder = Folder(tmp_path)
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "x").touch()
    with pytest.raises(StorageError, match="there"):
        folder.write("there", b"x")
    with pytest.raises(StorageError, match="there"):
        folder.write_all("there", {"a.obj": b"x"})
    with pytest.raises(OutsideFolder):
        folder.write_all("other", {"../a.obj": b"x"})
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    assert (folder.write_all("new", {"a.obj": b"x"}) / "a.obj").read_bytes() == b"x"
