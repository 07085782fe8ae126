"""Numbers of scene files: no truth values, no text, and bounds that say what was probably meant."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from rlbench_pin.errors import SceneFileError
from rlbench_pin.scene import SceneSpec, read_scene

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
    with pytest.raises(SceneFileError, match=r"'waypoint0', key 'arc.angle': .*at most one turn.*degrees") as caught:
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
