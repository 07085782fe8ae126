"""Packages of tasks: found by their entry points, and none of them breaks the others."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.tasks.test_task_files import CLASS

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
    assert "rlbench_pin itself" in said["reach_target"] and "'claims 1.2'" in said["reach_target"]
    assert "'twin_one 1.2'" in said["same_name"] and "'twin_two 1.2'" in said["same_name"]
    assert "calls itself 'touch_me'" in said["mislabelled"]
    assert "module:Class" in said["other"] and "small letters" in said["Bad Name"]


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("name", "says"),
    [("same_name", "neither is used"), ("bad_import", "cannot be loaded"), ("touch_nothin", "Did you mean 'touch_nothing'")],
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
