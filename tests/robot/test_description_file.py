"""An arm that a TOML file outside the package describes."""

from __future__ import annotations

import pickle
from dataclasses import fields
from pathlib import Path

import pytest

from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.recording.config import RecordConfig
from rlbench_pin.robot import RobotDescription, UnknownRobot, robot_description
from rlbench_pin.robot.description import RobotFileError


def toml_text(description: RobotDescription, **changes: str) -> str:
    """Return the file of an arm, with other texts for some keys; an empty text leaves a key out."""
    lines = {}
    for key in (field.name for field in fields(RobotDescription) if field.name != "file"):
        value = getattr(description, key)
        lines[key] = (
            str(list(value)) if isinstance(value, tuple) else f'"{value}"' if isinstance(value, str | Path) else str(value)
        )
    return "".join(f"{key} = {text}\n" for key, text in (lines | changes).items() if text)


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """The file of a Panda that stands elsewhere."""
    file = tmp_path / "tall.toml"
    file.write_text(toml_text(robot_description("panda"), name='"tall"', base_pose="[-0.25, 0.0, 0.8, 0, 0, 0, 1]"))
    return file


def test_a_file_is_an_arm(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its fields are those of the file; the reference finds it again from another folder."""
    monkeypatch.chdir(arm.parent)
    found = robot_description("tall.toml")
    assert (found.name, found.base_pose[2], found.reference) == ("tall", 0.8, str(arm))
    assert robot_description(arm) == found == pickle.loads(pickle.dumps(found))
    monkeypatch.chdir("/")
    assert robot_description(found.reference) == found


def test_paths_are_relative_to_the_file(arm: Path) -> None:
    """Not to the folder of the program."""
    panda = robot_description("panda")
    (arm.parent / "tall.srdf").write_bytes(panda.srdf.read_bytes())
    arm.write_text(toml_text(panda, name='"tall"', srdf='"tall.srdf"'))
    assert robot_description(arm).srdf == arm.parent / "tall.srdf"


@pytest.mark.parametrize(
    ("key", "text", "says"),
    [
        ("hom", "[0.0]", "key 'hom': is unknown. Did you mean 'home'"),
        ("reach", "", "key 'reach': is missing. The Panda has reach = 1.6"),
        ("reach", "-1.0", "key 'reach': has to be a finite number > 0"),
        ("home", "[0.0, 1.0]", "key 'home': has to have shape"),
        ("urdf", '"none.urdf"', "key 'urdf': has to be an existing file;"),
        ("name", '"panda"', "is an arm of the catalogue"),
        ("name", '"My Arm"', "lower case letters"),
        ("gripper_joints", '["a"]', "a list of 0 or 2 names"),
        ("arm_joints", '"panda_joint1"', "a list of 1 to 32 names"),
        ("loaded_joints", "9", "key 'loaded_joints': has to be a whole number"),
        ("base_pose", "[0, 0, 0, 0, 0, 0, 3]", "quaternion of norm 3"),
        ("name", "tall", "cannot be read as TOML"),
    ],
)
def test_a_wrong_file_says_where_and_what_to_do(tmp_path: Path, key: str, text: str, says: str) -> None:
    """The error names file, key and what is possible."""
    file = tmp_path / "wrong.toml"
    file.write_text(toml_text(robot_description("panda"), **{"name": '"wrong"', key: text}))
    with pytest.raises(RobotFileError) as caught:
        robot_description(file)
    assert says in str(caught.value)
    assert str(file) in str(caught.value)


def test_names_of_the_catalogue_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder called like an arm changes nothing; other names are unknown, missing files say how to make one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "panda").mkdir()
    assert robot_description("panda").file is None
    with pytest.raises(UnknownRobot):
        robot_description("tall")
    with pytest.raises(RobotFileError, match="does not exist.*arm new"):
        robot_description("tall.toml")


def test_settings_keep_what_finds_it_again(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also in a worker process that runs in another folder."""
    monkeypatch.chdir(arm.parent)
    config = RecordConfig(tasks=("reach_target",), robot="tall.toml", paired=("tall.toml", "ur5e"))
    assert (config.robot, config.paired) == (str(arm), ("ur5e",))


@pytest.mark.simulation
def test_it_demonstrates(arm: Path) -> None:
    """The demonstration names the file, so that its replay finds the arm."""
    with make_environment(low_dim_config(), robot=str(arm)) as environment:
        task = environment.get_task("reach_target")
        demo = task.get_demos(1, live_demos=True, seed=0)[0]
        assert demo.robot == str(arm)
        task.reset_to_demo(demo)
