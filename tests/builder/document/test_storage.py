"""Both files appear together or not at all, whenever the process is killed."""

from __future__ import annotations

import itertools
import os
import random
import signal
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rlbench_pin.builder.document import ChangedOnDisk, TaskDocument, TaskFilesError, storage
from rlbench_pin.builder.document.storage import MAX_FILE_SIZE, Pair, write_pair
from rlbench_pin.errors import InvalidValue, StorageError
from rlbench_pin.tasks import LIBRARY
from tests.builder.document.conftest import Opener

OLD, NEW = (b"format = 2\n", b"x = 1\n"), (b"format = 2\n# new\n", b"x = 2\n")
STEPS = ("open", "os.rename", "open", "open", "os.rename", "os.rename", "os.remove")
"""Steps of a save: the journal and two files, each written and put in place; then the journal is removed."""


def _pair(folder: Path) -> Pair:
    pair = Pair(folder, "thing")
    write_pair(pair, OLD)
    return pair


def _contents(pair: Pair) -> tuple[bytes, ...]:
    return tuple(path.read_bytes() for path in pair.files)


def _writes(heard: Callable[[str], object]) -> None:
    """Call back before each file is opened for writing, replaced or removed, as long as this process lives."""

    def listen(event: str, args: tuple[object, ...]) -> None:
        if event in ("os.rename", "os.remove") or (event == "open" and args[1] == "w"):
            heard(event)

    sys.addaudithook(listen)


def _killed_save(pair: Pair, step: int) -> None:
    """Save in another process, which is killed right before a step."""
    process = os.fork()
    if process == 0:
        steps = iter(range(step))
        _writes(lambda event: os.kill(os.getpid(), signal.SIGKILL) if next(steps, None) is None else None)
        write_pair(pair, NEW)
        os._exit(0)
    assert os.WIFSIGNALED(os.waitpid(process, 0)[1])


@pytest.mark.parametrize("step", range(len(STEPS)))
def test_a_save_that_is_killed_is_finished_or_dropped(tmp_path: Path, step: int) -> None:
    """Before each step: what is opened next is old in both files, or new in both, and nothing else is left in the folder."""
    pair = _pair(tmp_path)
    _killed_save(pair, step)
    document = TaskDocument.open(pair.files[0])
    assert _contents(pair) == (OLD if step < 2 else NEW) and not document.unsaved
    assert sorted(file.name for file in tmp_path.iterdir()) == ["thing.py", "thing.toml"]


@pytest.mark.parametrize("step", range(len(STEPS)))
def test_a_first_save_that_is_killed_leaves_both_files_or_none(tmp_path: Path, step: int) -> None:
    """A task of that name cannot be begun anew over what was being saved."""
    pair = Pair(tmp_path, "thing")
    _killed_save(pair, step)
    if step < 2:
        assert TaskDocument.new(tmp_path, "thing").unsaved
        assert list(tmp_path.iterdir()) == []
        return
    with pytest.raises(TaskFilesError, match="already exists"):
        TaskDocument.new(tmp_path, "thing")
    assert _contents(pair) == NEW
    assert sorted(file.name for file in tmp_path.iterdir()) == ["thing.py", "thing.toml"]


def test_a_save_has_these_steps(tmp_path: Path) -> None:
    """So that the tests above leave none out."""
    pair = _pair(tmp_path)
    read, write = os.pipe()
    process = os.fork()
    if process == 0:
        _writes(lambda event: os.write(write, f"{event} ".encode()))
        write_pair(pair, NEW)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as events:
        assert tuple(events.read().split()) == STEPS
    os.waitpid(process, 0)


def test_files_that_were_changed_after_a_kill_stay(tmp_path: Path) -> None:
    """They are not overwritten: what was being saved is an edit that can be undone."""
    pair = _pair(tmp_path)
    _killed_save(pair, 4)
    pair.files[1].write_text("x = 3\n")
    document = TaskDocument.open(pair.files[0])
    assert pair.files[1].read_text() == "x = 3\n" and pair.files[0].read_bytes() == OLD[0]
    assert document.python_text == "x = 2\n" and document.unsaved and document.undoable == "unfinished save"
    document.undo()
    assert document.python_text == "x = 3\n" and not document.unsaved
    assert not pair.journal.exists()


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b'{"format": 9}', b'{"format": 1, "before": [], "files": [1, 2]}', b"\xff"]
)
def test_a_journal_that_is_none_is_ignored(tmp_path: Path, content: bytes) -> None:
    """It does not stand in the way of opening or saving."""
    pair = _pair(tmp_path)
    pair.journal.write_bytes(content)
    assert TaskDocument.open(pair.files[0]).scene_text == OLD[0].decode()
    write_pair(pair, NEW)
    assert _contents(pair) == NEW and not pair.journal.exists()


@pytest.mark.simulation
def test_saves_that_are_killed_at_any_instant_lose_nothing(tmp_path: Path) -> None:
    """A process saves without end and is killed: the two files always belong together, and are not older than its word."""
    rng = random.Random(0)
    for _ in range(12):
        pair = _pair(tmp_path)
        said, word = os.pipe()
        process = os.fork()
        if process == 0:
            for number in range(10**6):
                write_pair(pair, (b"# %d\n" % number * 2000, b"# %d\n" % number * 2000))
                os.write(word, b"%d\n" % number)
        os.close(word)
        with os.fdopen(said) as lines:
            assert lines.readline() == "0\n"
            time.sleep(rng.uniform(0.0, 0.05))
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)
            last = max((int(line) for line in lines), default=0)
        document = TaskDocument.open(pair.files[0])
        assert document.scene_text == document.python_text
        (number_there,) = {int(line.removeprefix("# ")) for line in document.scene_text.splitlines()}
        assert number_there in (last, last + 1)
        assert sorted(file.name for file in tmp_path.iterdir()) == ["thing.py", "thing.toml"]


def test_a_save_that_fails_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With an error of ours, and nothing else in the folder."""
    pair, sync, synced = _pair(tmp_path), os.fsync, itertools.count()

    def full(descriptor: int) -> None:
        if next(synced) == 3:  # the journal and its folder, the scene, the Python
            raise OSError(28, "No space left on device")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StorageError, match="No space left"):
        write_pair(pair, NEW)
    assert next(synced) == 4
    assert _contents(pair) == OLD
    assert sorted(file.name for file in tmp_path.iterdir()) == ["thing.py", "thing.toml"]


def test_saving_says_what_is_unsaved(opened: Opener) -> None:
    """An edit makes a task unsaved, saving and undoing make it saved again."""
    document = opened("open_drawer")
    document.set("waypoint0", "gripper", "close")
    assert document.unsaved
    document.save()
    assert not document.unsaved
    document.undo()
    assert document.unsaved
    document.redo()
    assert not document.unsaved


def test_files_that_somebody_changed_are_not_overwritten(opened: Opener) -> None:
    """Saving says so, unless it is told to; reloading takes them over as an edit that can be undone."""
    document = opened("open_drawer")
    file = document.folder / "open_drawer.py"
    file.write_text(file.read_text() + "\n# by hand\n")
    assert document.changed_on_disk() == (file,)
    document.set("waypoint0", "gripper", "close")
    with pytest.raises(ChangedOnDisk, match="open_drawer.py changed on disk"):
        document.save()
    edited = document.scene_text
    document.reload()
    assert document.python_text.endswith("# by hand\n") and 'gripper = "open"' in document.scene_text
    assert document.undoable == "reload" and not document.changed_on_disk() and not document.unsaved
    document.undo()
    assert document.scene_text == edited and not document.python_text.endswith("# by hand\n")
    document.save()
    file.write_text("# other\n")
    document.save(over=True)
    assert file.read_text() == document.python_text


def test_line_ends_and_letters_stay(tmp_path: Path) -> None:
    """Files whose lines end with a carriage return, too, keep that; so do letters of any language."""
    pair = Pair(tmp_path, "thing")
    scene = '# Größe 长\r\nformat = 2\r\n\r\n[[frame]]\r\nname = "a"   # あ\r\n'.encode()
    write_pair(pair, (scene, b"x = 1\n"))
    document = TaskDocument.open(pair.files[0])
    document.set_scene_text(document.scene_text.replace("\n", "\r\n"))
    assert document.step == 0
    with pytest.raises(InvalidValue, match="UTF-8"):
        document.set_scene_text("\ud800")
    document.set("a", "pose", [0.1, 0.0, 0.0])
    document.save()
    assert pair.files[0].read_bytes() == scene + b"pose = [0.1, 0.0, 0.0]\r\n"
    assert pair.files[1].read_bytes() == b"x = 1\n"


def test_what_is_no_task_is_not_opened(tmp_path: Path) -> None:
    """A missing file, one that is no text, one that is too large, another kind of file: refused with what to do."""
    pair = _pair(tmp_path)
    with pytest.raises(TaskFilesError, match="not a file of a task"):
        TaskDocument.open(tmp_path / "thing.txt")
    with pytest.raises(TaskFilesError, match=r"other.toml'.*does not exist"):
        TaskDocument.open(tmp_path / "other.py")
    with pytest.raises(TaskFilesError, match=r"open_drawer2.toml'.*from the scene .open_drawer.\. Open that task"):
        TaskDocument.open(LIBRARY / "open_drawer2.toml")
    pair.files[0].write_bytes(b"\xff\xfe")
    with pytest.raises(TaskFilesError, match="not UTF-8"):
        TaskDocument.open(pair.files[0])
    with pair.files[0].open("wb") as file:
        file.truncate(MAX_FILE_SIZE + 1)
    with pytest.raises(TaskFilesError, match="at most"):
        TaskDocument.open(pair.files[0])
    with pytest.raises(TaskFilesError, match="already exists"):
        TaskDocument.new(tmp_path, "thing")
    with pytest.raises(TaskFilesError, match="not a valid task name"):
        TaskDocument.new(tmp_path, "../thing")
    for name in ("none", "lambda", "task"):
        with pytest.raises(TaskFilesError, match="another name"):
            TaskDocument.new(tmp_path, name)


def test_two_builders_that_save_at_once_do_not_mix_their_files(tmp_path: Path) -> None:
    """Both files are of one save, and whoever comes second is told."""
    pair = _pair(tmp_path)
    barrier = threading.Barrier(2)

    def save(number: int) -> bool:
        document = TaskDocument.open(pair.files[0])
        document.set_scene_text(f"format = 2\n# {number}\n")
        document.set_python_text(f"x = {number}\n")
        barrier.wait()
        try:
            document.save()
        except ChangedOnDisk:
            return False
        return True

    for turn in range(30):
        with ThreadPoolExecutor(2) as pool:
            done = list(pool.map(save, (100 + 2 * turn, 101 + 2 * turn)))
        assert sorted(done) == [False, True]
        number = 100 + 2 * turn + done.index(True)
        assert _contents(pair) == (f"format = 2\n# {number}\n".encode(), f"x = {number}\n".encode())
    assert sorted(file.name for file in tmp_path.iterdir()) == ["thing.py", "thing.toml"]


def test_a_folder_that_another_builder_holds_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a while, and nothing was written."""
    monkeypatch.setattr(storage, "_PATIENCE", 0.1)
    pair = _pair(tmp_path)
    with storage.alone_in(tmp_path), pytest.raises(StorageError, match="another task builder"):
        write_pair(pair, NEW)
    assert _contents(pair) == OLD


def test_what_a_killed_writer_leaves_goes_at_the_next_opening(tmp_path: Path) -> None:
    """Of a draft, too."""
    pair = _pair(tmp_path)
    for part in pair.parts:
        part.write_bytes(b"half")
    TaskDocument.open(pair.files[1])
    assert sorted(file.name for file in tmp_path.iterdir()) == ["thing.py", "thing.toml"]


def test_a_task_is_not_begun_over_a_link_that_leads_nowhere(tmp_path: Path) -> None:
    """The link stays."""
    (tmp_path / "thing.py").symlink_to("thing.py")
    with pytest.raises(TaskFilesError, match="already exists"):
        TaskDocument.new(tmp_path, "thing")
    assert (tmp_path / "thing.py").is_symlink()
