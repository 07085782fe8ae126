"""Task classes by name and by file, and tasks that other packages bring."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import rlbench_pin.tasks as tasks
from rlbench_pin.errors import RlbenchPinError, SceneFileError, TaskError, UnknownName
from rlbench_pin.tasks import (
    Task,
    find_task,
    is_task_file,
    load_task_file,
    own_tasks,
    task_class,
    task_digest,
    task_names,
    task_reference,
    task_scene,
)
from rlbench_pin.tasks.registry import task_files

NAMES = {
    "close_microwave", "meat_off_grill", "open_drawer", "pick_and_lift", "push_button", "put_rubbish_in_bin", "reach_target",
    "slide_block_to_target", "stack_blocks", "take_lid_off_saucepan",
}  # fmt: skip

OWN_TASK = """
from rlbench_pin.tasks import ListEmpty, Task


class TouchNothing(Task):
    def init_task(self):
        self.register_success_conditions([ListEmpty([])])

    def init_episode(self, variation, rng):
        return ["Touch nothing."]

    def variation_count(self):
        return 1
"""


def test_the_library_holds_the_first_ten_tasks_and_lists_all_in_alphabetical_order() -> None:
    """Each is a pair of files with one stem."""
    assert set(task_names()) >= NAMES
    assert list(task_names()) == sorted(task_names())


def test_a_task_is_found_by_either_name() -> None:
    """Snake case, camel case, or as an attribute of the package."""
    assert task_class("reach_target") is task_class("ReachTarget") is tasks.ReachTarget
    assert task_class("reach_target").get_name() == "reach_target"
    assert "ReachTarget" in dir(tasks)
    with pytest.raises(AttributeError, match="RaechTarget"):
        _ = tasks.RaechTarget


def test_an_unknown_task_is_answered_with_the_nearest() -> None:
    """And with the command that lists them all."""
    with pytest.raises(UnknownName, match=r"No task is called 'reach_taget'. Did you mean 'reach_target'\? `rlbench-pin list`"):
        task_class("reach_taget")


@pytest.mark.simulation
def test_only_the_asked_task_is_imported() -> None:
    """Listing and importing one leaves the others, and the simulator, alone."""
    code = (
        "import sys; from rlbench_pin.tasks import ReachTarget, task_names; task_names();"
        "assert not any(m.startswith('rlbench_pin.tasks.library.') and not m.endswith('reach_target') for m in sys.modules);"
        "assert 'pybullet' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(tasks.__file__).parents[2])


def test_a_scene_is_read_once() -> None:
    """The second time it is the same object."""
    assert task_scene(task_class("push_button")) is task_scene(task_class("push_button"))


def test_a_task_outside_the_package_brings_its_scene(tmp_path: Path) -> None:
    """The scene lies beside the file and is read again when it changes."""
    file = tmp_path / "touch_nothing.py"
    file.write_text(OWN_TASK)
    task = load_task_file(file)
    assert issubclass(task, Task)
    assert task.get_name() == "touch_nothing"
    with pytest.raises(SceneFileError, match=r"touch_nothing\.toml"):
        task_scene(task)
    file.with_suffix(".toml").write_text("format = 1")
    assert task_scene(task).waypoint == ()
    file.with_suffix(".toml").write_text('format = 1\n[[waypoint]]\nname = "waypoint0"')
    assert len(task_scene(task).waypoint) == 1


def test_a_file_without_its_class_is_refused(tmp_path: Path) -> None:
    """The class is named after the file."""
    with pytest.raises(TaskError, match="does not exist"):
        load_task_file(tmp_path / "none.py")
    (tmp_path / "other_name.py").write_text(OWN_TASK)
    with pytest.raises(TaskError, match="no class 'OtherName'"):
        load_task_file(tmp_path / "other_name.py")


CLASS = """
from rlbench_pin.tasks import ListEmpty, Task


class {name}(Task):
    def init_task(self):
        self.register_success_conditions([ListEmpty([])])

    def init_episode(self, variation, rng):
        return ["Touch nothing."]
"""


def write_task(folder: Path, stem: str = "touch_nothing", code: str | None = None, scene: str = "format = 2\n") -> Path:
    """Write a pair of files and return the Python file."""
    folder.mkdir(parents=True, exist_ok=True)
    name = "".join(word.capitalize() for word in stem.split("_"))
    (folder / f"{stem}.toml").write_text(scene)
    file = folder / f"{stem}.py"
    file.write_text(CLASS.format(name=name) if code is None else code)
    return file


def test_an_unchanged_file_is_run_once_and_a_changed_one_again(tmp_path: Path) -> None:
    """The class stays the same object until the file changes; the file is found as text or path, from any folder."""
    file = write_task(tmp_path)
    first = find_task(str(file))
    assert first is find_task(file) is load_task_file(tmp_path / "x" / ".." / file.name)
    assert is_task_file(first) and not is_task_file(task_class("reach_target"))
    assert task_reference(first) == str(file) and task_reference(task_class("reach_target")) == "reach_target"
    before = task_digest(first)
    file.write_text(file.read_text() + "\n# changed\n")
    assert find_task(file) is not first
    assert task_digest(find_task(file)) != before
    assert task_digest(task_class("reach_target")) == ""


def test_nothing_is_written_beside_the_file_and_no_bytecode_is_taken(tmp_path: Path) -> None:
    """What runs is the text that one can read."""
    file = write_task(tmp_path)
    load_task_file(file)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["touch_nothing.py", "touch_nothing.toml"]


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("def f(:\n", "SyntaxError"),
        ("\n\nimport no_such_module\n", "ModuleNotFoundError: No module named 'no_such_module'. See its line 3"),
        ("raise SystemExit(3)\n", "SystemExit"),
        ("1 / 0\n", "ZeroDivisionError"),
        ("x = 1\n", "no class 'TouchNothing'"),
        ("TouchNothing = 3\n", "no class 'TouchNothing'"),
        ("\0", "cannot be loaded"),
        ("\xff", "cannot be loaded"),
        ("", "no class 'TouchNothing'"),
    ],
)
def test_a_file_that_cannot_be_loaded_is_refused_with_the_reason(code: str, says: str, tmp_path: Path) -> None:
    """Whatever the file raises becomes one kind of error, and no half of it stays behind."""
    file = write_task(tmp_path)
    file.write_bytes(code.encode("latin-1"))
    before = set(sys.modules)
    with pytest.raises(TaskError) as caught:
        find_task(file)
    assert says in str(caught.value) and str(file) in str(caught.value)
    assert not {name for name in set(sys.modules) - before if name.startswith("rlbench_pin_task_")}


def test_paths_that_are_no_task_files_are_refused(tmp_path: Path) -> None:
    """The nearest that works is named."""
    file = write_task(tmp_path)
    for path, says in {
        str(file.with_suffix("")): rf"Did you mean '{file}'",
        str(file.with_suffix(".toml")): "must end with `.py`",
        str(tmp_path): "does not exist",
        "nowhere/x.py": "rlbench-pin new",
    }.items():
        with pytest.raises(TaskError, match=says):
            find_task(path)
    with pytest.raises(UnknownName):
        find_task("touch_nothing")


def test_two_files_of_one_name_are_told_apart(tmp_path: Path) -> None:
    """Each has a class of its own; naming both at once is refused."""
    one, other = write_task(tmp_path / "a"), write_task(tmp_path / "b")
    assert find_task(one) is not find_task(other)
    assert list(own_tasks([one, one])) == ["touch_nothing"]
    with pytest.raises(TaskError, match="Two task files have the name 'touch_nothing'"):
        own_tasks([one, other])


def test_models_of_its_own_belong_to_a_task(tmp_path: Path) -> None:
    """The URDF, its mesh, the material of the mesh and the image of the material."""
    models = tmp_path / "models"
    models.mkdir()
    (models / "thing.urdf").write_text(
        '<robot name="thing"><link name="thing"><visual><geometry><mesh filename="thing.obj"/></geometry></visual></link></robot>'
    )
    (models / "thing.obj").write_text("mtllib thing.mtl\nv 0 0 0\n")
    (models / "thing.mtl").write_text("newmtl a\nmap_Kd thing.png\n")
    (models / "thing.png").write_bytes(b"png")
    (models / "other.png").write_bytes(b"png")
    scene = 'format = 2\n[[body]]\nname = "thing"\nasset = "./models/thing.urdf"\n'
    task = load_task_file(write_task(tmp_path, scene=scene))
    names = {"touch_nothing.py", "touch_nothing.toml", *(f"models/thing.{end}" for end in ("urdf", "obj", "mtl", "png"))}
    assert set(task_files(task)) == names


@pytest.mark.simulation
def test_a_dataclass_of_a_task_file_works_and_the_file_needs_no_package(tmp_path: Path) -> None:
    """Annotations are looked up in the module of the file; a process elsewhere loads it by its path."""
    code = (
        "from __future__ import annotations\nfrom dataclasses import dataclass\n"
        + CLASS.format(name="TouchNothing")
        + "\n\n@dataclass(frozen=True)\nclass Plan:\n    height: float = 0.1\n"
    )
    file = write_task(tmp_path, code=code)
    program = f"from rlbench_pin.tasks import find_task; print(find_task({str(file)!r}).get_name())"
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd="/", timeout=60)
    assert result.stdout == "touch_nothing\n", result.stderr


def test_all_refusals_are_ours(tmp_path: Path) -> None:
    """A folder called like a file, and a file that may not be read."""
    (tmp_path / "folder.py").mkdir()
    with pytest.raises(RlbenchPinError, match="does not exist"):
        find_task(tmp_path / "folder.py")


ROOT = Path(__file__).resolve().parents[2]
SETUP = "from rlbench_pin.tasks import *; from rlbench_pin.tasks import plugin_faults, task_origin\n"


def install(site: Path, package: str, entries: str, code: dict[str, str], group: str = "rlbench_pin.tasks") -> None:
    """Put a package where an installer would: modules with scenes, and the metadata with the entry points."""
    folder = site / package
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    for stem, text in code.items():
        (folder / f"{stem}.py").write_text(text)
        (folder / f"{stem}.toml").write_text("format = 2\n")
    info = site / f"{package}-1.2.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{entries}")


def run(site: Path, code: str, *flags: str) -> str:
    """Run a program that sees the packages in `site`, and return what it prints."""
    environment = {**os.environ, "PYTHONPATH": f"{site}{os.pathsep}{ROOT}"}
    command = [sys.executable, *flags, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, cwd=site)
    assert result.returncode == 0, result.stderr
    return result.stdout + result.stderr


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sound package, and others that are broken in every way that we know."""
    site = tmp_path_factory.mktemp("site")
    good = CLASS.format(name="TouchNothing")
    install(site, "good", "touch_nothing = good.touch_nothing:TouchNothing\n", {"touch_nothing": good})
    install(site, "raises", "bad_import = raises.bad_import:BadImport\n", {"bad_import": "import no_such_module\n"})
    install(site, "gone", "gone_away = gone.nowhere:GoneAway\nno_class = gone.no_class:NoClass\n", {"no_class": "NoClass = 3\n"})
    install(
        site, "claims", "reach_target = claims.reach_target:ReachTarget\n", {"reach_target": CLASS.format(name="ReachTarget")}
    )
    for twin in ("twin_one", "twin_two"):
        install(site, twin, f"same_name = {twin}.same_name:SameName\n", {"same_name": CLASS.format(name="SameName")})
    install(
        site, "wrong", "Bad Name = wrong.x:X\nother = wrong\nmislabelled = wrong.y:TouchMe\n", {"y": CLASS.format(name="TouchMe")}
    )
    install(site, "foreign", "x = y:z\n", {}, group="somebody.else")
    return site


@pytest.mark.simulation
def test_a_sound_package_is_listed_and_the_broken_ones_are_reported(site: Path) -> None:
    """Names come after those of the library; faults name the package and what to do."""
    out = run(site, SETUP + "print(task_names()[-4:], task_origin('touch_nothing'), task_class('TouchNothing').get_name())\n"
                            "for name, fault in plugin_faults().items(): print(name, '|', fault)")  # fmt: skip
    first, *faults = out.splitlines()
    assert "'touch_nothing'" in first and first.endswith("good 1.2 touch_nothing")
    said = dict(line.split(" | ") for line in faults)
    assert said.keys() == {
        "bad_import", "gone_away", "no_class", "reach_target", "same_name", "Bad Name", "other", "mislabelled"
    }  # fmt: skip
    assert "'raises 1.2'" in said["bad_import"] and "No module named 'no_such_module'" in said["bad_import"]
    assert "rlbench_pin has a task of that name" in said["reach_target"] and "'claims 1.2'" in said["reach_target"]
    assert "'twin_one 1.2'" in said["same_name"] and "'twin_two 1.2'" in said["same_name"]
    assert "calls itself 'touch_me'" in said["mislabelled"]
    assert "module:Class" in said["other"] and "lower-case letters" in said["Bad Name"]


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("same_name", "these tasks are ignored"),
        ("bad_import", "cannot be loaded"),
        ("touch_nothin", "Did you mean 'touch_nothing'"),
    ],
)
def test_a_name_that_does_not_work_says_why(site: Path, name: str, says: str) -> None:
    """A clash names both origins, a broken module its error, a misspelt name the nearest."""
    out = run(site, SETUP + f"from rlbench_pin.errors import RlbenchPinError\ntry: task_class({name!r})\n"
                            "except RlbenchPinError as error: print(error)")  # fmt: skip
    assert says in out


@pytest.mark.simulation
def test_the_library_is_not_touched_by_a_package_that_claims_its_name(site: Path) -> None:
    """The task of the library stays what it is."""
    out = run(site, SETUP + "print(task_class('reach_target').__module__)")
    assert out == "rlbench_pin.tasks.library.reach_target\n"


@pytest.mark.simulation
def test_list_shows_the_package_and_goes_on(site: Path) -> None:
    """The list says who brings a task; what is broken is said beside it."""
    out = run(site, "from rlbench_pin.cli.main import main; raise SystemExit(main(['list']))")
    assert "[good 1.2]" in out and "reach_target" in out
    assert out.count("rlbench-pin: ") == 8
    assert not [line for line in out.splitlines() if line.startswith(("bad_import", "same_name", "mislabelled"))]


@pytest.mark.simulation
def test_importing_the_package_reads_no_entry_points(site: Path) -> None:
    """They are read when names are asked for."""
    out = run(
        site, "import rlbench_pin, sys; print('importlib.metadata' in sys.modules and 'rlbench_pin.plugins' in sys.modules)"
    )
    assert out == "False\n"


@pytest.mark.simulation
def test_gymnasium_ids_are_made_when_asked_for(site: Path) -> None:
    """`register_plugin_tasks` registers what works, and only that."""
    out = run(site, "import rlbench_pin.gym as g; print(g.register_plugin_tasks(), g.register_plugin_tasks())")
    ids = "('rlbench_pin/touch_nothing-state-v0', 'rlbench_pin/touch_nothing-vision-v0')"
    assert out == f"{ids} {ids}\n"


@pytest.mark.simulation
def test_metadata_that_cannot_be_read_is_a_fault_of_that_package(tmp_path: Path) -> None:
    """The others go on. Gymnasium, which reads the entry points of all packages, would not start here, so it stays out."""
    install(tmp_path, "noise", "this is no entry at all\n", {})
    install(tmp_path, "good", "touch_nothing = good.touch_nothing:TouchNothing\n", {})
    file = ROOT / "rlbench_pin" / "plugins.py"
    out = run(
        tmp_path,
        "import importlib.util as u, sys\n"
        f"spec = u.spec_from_file_location('plugins', {str(file)!r}); m = u.module_from_spec(spec); sys.modules['plugins'] = m\n"
        "spec.loader.exec_module(m); found = m.installed_plugins(()); print(list(found.tasks), found.faults)",
    )
    assert out.startswith("['touch_nothing'] {'noise': \"The entry points of 'noise 1.2' cannot be read")
