"""Tasks of the library, copied to a folder in which they may be changed."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.scene import read_scene
from rlbench_pin.tasks import LIBRARY, library_names

Opener = Callable[[str], TaskDocument]
EDITABLE = tuple(name for name in library_names() if read_scene(LIBRARY / f"{name}.toml").base is None)
"""Tasks of the library whose scene stands in one file."""


@pytest.fixture
def opened(tmp_path: Path) -> Opener:
    """Open a copy of a task of the library."""

    def open_copy(name: str) -> TaskDocument:
        for end in (".toml", ".py"):
            shutil.copy(LIBRARY / f"{name}{end}", tmp_path)
        return TaskDocument.open(tmp_path / f"{name}.toml")

    return open_copy
