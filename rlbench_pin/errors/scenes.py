"""Scene files, assets and models of robots that cannot be used."""

from __future__ import annotations

from pathlib import Path

from rlbench_pin.errors.base import InvalidValue, RlbenchPinError


class SceneFileError(RlbenchPinError):
    """A scene file cannot be used; says which file, which table and which key."""

    def __init__(self, file: Path | str, where: str, problem: str, hint: str = "") -> None:
        self.file, self.where, self.problem, self.hint = Path(file), where, problem, hint
        super().__init__(f"{self.file.name}: {where}: {problem}" + (f" {hint}" if hint else ""))


class InvalidRecord(InvalidValue):
    """A record of a scene, such as `FrameSpec`, was made by hand of something it cannot hold; says which key."""

    def __init__(self, record: str, key: str, value: object, problem: str, hint: str = "") -> None:
        super().__init__(record, value, problem, hint)
        self.record, self.key = record, key
        self.args = (f"{record}{f', key {key!r}' if key else ''}: {problem}{f' {hint}' if hint else ''}",)


class AssetNotFound(RlbenchPinError):
    """A URDF or mesh that a scene refers to does not exist."""

    def __init__(self, path: Path | str, needed_by: str) -> None:
        self.path, self.needed_by = Path(path), needed_by
        super().__init__(
            f"Asset '{path}' needed by {needed_by} does not exist. "
            "Check the spelling, or rebuild the assets with `python scripts/build_assets.py`."
        )


class AssetInvalid(RlbenchPinError):
    """A URDF was found but a simulator or Pinocchio could not load it."""

    def __init__(self, path: Path | str, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"Asset '{path}' cannot be loaded: {problem}")


class RobotModelError(RlbenchPinError):
    """A robot description and its URDF disagree, or a configuration has the wrong shape."""
