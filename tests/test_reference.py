"""The pages of `docs/reference/` are what the code says, and what they say is true of a running environment."""

from __future__ import annotations

import inspect
import re
import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from reference_lib import command_line, observations, scene_files
from write_reference import FOLDER, PAGES, written_anew

from rlbench_pin.cli.main import COMMANDS
from rlbench_pin.cli.process.running import parse
from rlbench_pin.environment import Environment, JointPositionActionMode, ModelObservationConfig
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import SceneFileError
from rlbench_pin.observation import FIELDS, Observation
from rlbench_pin.scene import read_scene
from rlbench_pin.spatial import TABLE_HEIGHT
from rlbench_pin.tasks import Condition, Task, conditions, library_names, task_class
from tests.cli.support import exit_code


def page(name: str) -> str:
    """Return the text of a page."""
    return (FOLDER / f"{name}.md").read_text(encoding="utf-8")


def part(name: str, marker: str) -> str:
    """Return one generated part of a page."""
    found = re.search(rf"<!-- generated: {marker} -->(.*?)<!-- /generated: {marker} -->", page(name), re.DOTALL)
    assert found, marker
    return found[1]


def rows(text: str) -> list[list[str]]:
    """Return the cells of all tables in a text, without their heads."""
    lines = [line.strip("| ").replace("\\|", "/") for line in text.splitlines() if line.startswith("|")]
    cells = [[cell.strip().strip("`") for cell in line.split(" | ")] for line in lines]
    rules = [i for i, row in enumerate(cells) if set(row[0]) <= set("-:")]
    return [row for i, row in enumerate(cells) if i not in rules and i + 1 not in rules]


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_what_the_code_says(name: str) -> None:
    """Written again, it stays as it is: otherwise run `python scripts/write_reference.py`."""
    before, after = written_anew(name)
    assert before == after, "run `python scripts/write_reference.py`"


def test_the_prose_has_the_height_of_the_table() -> None:
    """The one number of the world that pages say in a sentence."""
    for name in ("action_modes", "observations"):
        assert f"the table top at z = {TABLE_HEIGHT:g}." in page(name)


# Observations -----------------------------------------------------------------------------------------------------------------


def test_every_field_of_observations_has_its_row() -> None:
    """Joints, hand and task by name; pictures by what they deliver; misc by key, model-based ones by their setting."""
    found = {row[0] for marker in ("low-dim", "pictures") for row in rows(part("observations", marker))}
    pictures = {name.removeprefix("<camera>") for name in found if name.startswith("<camera>")}
    assert {name for name in FIELDS if name not in found and not name.endswith(tuple(pictures))} == {"ignore_collisions"} - found
    assert {f.name for f in fields(ModelObservationConfig)} <= {row[0] for row in rows(part("observations", "misc"))}


@pytest.mark.simulation
def test_a_demonstration_has_the_shapes_types_and_keys_of_the_page() -> None:
    """Of another task than that the page was written from."""
    config = observations.everything()
    with Environment(JointPositionActionMode(), obs_config=config) as environment:
        (demo,) = environment.get_task("push_button").get_demos(1, live_demos=True, seed=0)
    frame: Observation = demo[-1]
    for marker in ("low-dim", "pictures"):
        for name, shape, *_ in rows(part("observations", marker)):
            for camera in config.cameras() if "<camera>" in name else ("",):
                value = getattr(frame, name.replace("<camera>", camera))
                given = observations.shape_of(value)
                assert (re.sub(r"^\(\d+,\)", "(k,)", given) if name == "task_low_dim_state" else given) == shape, name
    listed = {row[0]: row[1] for row in rows(part("observations", "misc"))}
    for name, value in frame.misc.items():
        key = re.sub(rf"^({'|'.join(config.cameras())})(?=_camera_(?!matrix))", "<camera>", name)
        assert observations.shape_of(value) == listed.pop(key, observations.shape_of(value)), name
        assert key in observations.MISC
    assert listed == {}


@pytest.mark.simulation
@pytest.mark.parametrize("name", sorted(library_names()))
def test_the_state_of_a_task_has_the_numbers_of_the_page(name: str) -> None:
    """As many as listed, whatever the variation; by default the poses and joint values of what is listed, in that order."""
    _, count, text = next(row for row in rows(part("observations", "tasks")) if row[0] == name)
    with Environment(JointPositionActionMode(), obs_config=low_dim_config()) as environment:
        task = environment.get_task(name)
        for variation in {0, task.variation_count() - 1}:
            _, observation = task.reset(seed=1, variation=variation)
            assert observation.task_low_dim_state is not None
            assert len(observation.task_low_dim_state) == int(count)
        if task_class(name).get_low_dim_state is not Task.get_low_dim_state:
            return
        here, world = 0, task.world
        for thing in re.findall(r"[\w/]+(?=[`,;]|$)", re.sub(r" \[\w+\]", "", text)):
            values = np.atleast_1d(world.joint(thing).position if "/" in thing else world.body(thing).pose)
            np.testing.assert_array_equal(observation.task_low_dim_state[here : here + len(values)], values, err_msg=thing)
            here += len(values)
        assert here == int(count)


# Scene files ------------------------------------------------------------------------------------------------------------------


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
    assert len(read_scene(file).waypoint) == 4
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


# Conditions and hooks ---------------------------------------------------------------------------------------------------------


def test_every_condition_is_on_the_page() -> None:
    """Each class of the package that is a condition has a heading."""
    headings = set(re.findall(r"^### (\w+)$", part("conditions", "conditions"), re.MULTILINE))
    classes = {name for name, thing in vars(conditions).items() if inspect.isclass(thing) and issubclass(thing, Condition)}
    assert headings == classes - {"Condition"}


def test_every_method_of_a_task_is_on_the_page() -> None:
    """To override, to call, or called by the environment."""
    named = {
        row[0].split("(")[0] for marker in ("overridden", "called", "by-environment") for row in rows(part("conditions", marker))
    }
    methods = {name for name, thing in vars(Task).items() if inspect.isfunction(thing) and not name.startswith("_")}
    assert methods <= named


class Diary(task_class("push_button")):  # type: ignore[misc]
    """Notes what is called."""

    def __init__(self, world: object) -> None:
        super().__init__(world)
        self.calls: list[str] = []

    def init_task(self) -> None:
        """Note."""
        super().init_task()
        self.register_waypoint_ability_start(0, lambda _: self.calls.append("start hook"))
        self.register_waypoint_ability_end(0, lambda _: self.calls.append("end hook"))

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Note."""
        self.calls.append("init_episode")
        return super().init_episode(variation, rng)

    def base_rotation_bounds(self) -> object:
        """Note."""
        self.calls.append("place")
        return super().base_rotation_bounds()

    def reset_conditions(self) -> None:
        """Note."""
        super().reset_conditions()
        self.calls.append("reset_conditions")

    def step(self) -> None:
        """Note."""
        super().step()
        self.calls.append("step")

    def success(self) -> tuple[bool, bool]:
        """Note."""
        self.calls.append("conditions")
        return super().success()

    def decorate_observation(self, observation: Observation) -> Observation:
        """Note."""
        self.calls.append("observe")
        return observation

    def cleanup(self) -> None:
        """Note."""
        self.calls.append("cleanup")

    @classmethod
    def scene_file(cls) -> Path:
        """The scene of the task that is watched."""
        return task_class("push_button").scene_file()


@pytest.mark.simulation
def test_the_order_of_an_episode_is_that_of_the_page() -> None:
    """Layout, place, conditions from the settled instant; tick, conditions, observation; hooks around a leg; cleanup last."""
    with Environment(JointPositionActionMode(), obs_config=low_dim_config()) as environment:
        running = environment.get_task(Diary)
        diary = running.task
        assert isinstance(diary, Diary)
        running.reset(seed=0)
        assert [c for c in diary.calls if c != "reset_conditions"][-3:] == ["init_episode", "place", "observe"]
        assert diary.calls[-2] == "reset_conditions"
        diary.calls.clear()
        running.step(np.append(np.zeros(7), 0.04))
        assert diary.calls == ["step", "conditions", "observe"]
        diary.calls.clear()
        running.try_demo(seed=0, record=False)
        assert diary.calls[0] == "cleanup"
        assert diary.calls.index("start hook") < diary.calls.index("step") < diary.calls.index("end hook")


# Command line -----------------------------------------------------------------------------------------------------------------


def examples() -> list[str]:
    """Return the command lines of the page."""
    blocks = re.findall(r"```bash\n(.*?)```", page("command_line"), re.DOTALL)
    return [line.split("  #")[0].strip() for block in blocks for line in block.splitlines()]


def test_every_command_has_its_section_and_an_example() -> None:
    """Those of `dataset`, too."""
    headings = re.findall(r"^## (.*)$", page("command_line"), re.MULTILINE)
    assert set(headings) - {"Exit codes"} == {name.replace("-", " ", 1) for name in command_line.commands()}
    assert {heading.split()[0] for heading in headings} - {"Exit"} == set(COMMANDS)
    for heading in headings[1:]:
        assert any(line.startswith(f"rlbench-pin {heading}") for line in examples()), heading


@pytest.mark.parametrize("line", examples())
def test_the_parser_takes_the_examples(line: str) -> None:
    """As they stand."""
    assert callable(parse(line.split()[1:]).run)


@pytest.mark.parametrize("name", command_line.commands())
def test_the_page_has_the_flags_of_the_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """No flag more and none less than what the command prints."""
    assert exit_code(*name.replace("-", " ", 1).split(), "--help") == 0
    printed = set(re.findall(r"--[a-z][a-z-]+", capsys.readouterr().out)) - {"--help"}
    text = part("command_line", name)
    flags = {flag for row in rows(text) for flag in re.findall(r"--[a-z][a-z-]+", row[0])}
    assert flags <= printed
    assert printed <= set(re.findall(r"--[a-z][a-z-]+", text))


@pytest.mark.parametrize(
    ("words", "code"), [(("list",), 0), (("dataset", "info", "nowhere"), 1), (("view", "no_such_task"), 2), (("fly",), 2)]
)
def test_exit_codes_are_those_of_the_page(words: tuple[str, ...], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    """Done, failed, misused; `tests/cli` has those of interrupts and closed pipes."""
    assert exit_code(*words) == code
    assert str(code) in [row[0] for row in rows(part("command_line", "codes"))]
    assert capsys.readouterr().out if code == 0 else not capsys.readouterr().out
