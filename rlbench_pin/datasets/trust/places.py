"""Paths that stay in their dataset."""

from __future__ import annotations

import os
from pathlib import Path

from rlbench_pin.errors import EpisodeFileError


def check_inside(root: Path, path: Path) -> None:
    """Raise EpisodeFileError when a link leads from a path below `root` out of it; the root itself may be a link."""
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(root)):
        raise EpisodeFileError(path, f"'{path}' leads out of '{root}', to '{real}'. Do not trust this dataset.")
