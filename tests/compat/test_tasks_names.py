"""All names of the public task set are there, in every way that programs ask for them, and cost nothing before use."""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
from pathlib import Path

import pytest

from rlbench import tasks
from rlbench.backend.task import TASKS_PATH, Task
from rlbench_pin.compat import PACKAGES
from rlbench_pin.compat.known_tasks import KNOWN_TASKS, PERACT_TASKS
from rlbench_pin.evaluation.sets import gembench_tasks
from rlbench_pin.tasks import LIBRARY, camel_case, task_class, task_names
from tests.compat.support import python

SIZES = {
    "FS10_V1": (10, 5),
    "FS25_V1": (25, 5),
    "FS50_V1": (50, 5),
    "FS95_V1": (95, 5),
    "MT15_V1": (15,),
    "MT30_V1": (30,),
    "MT55_V1": (55,),
    "MT100_V1": (100,),
}
WITH_PYTHON = tuple(name for name in task_names() if (LIBRARY / f"{name}.py").is_file())
IN_NO_SET = {
    *("LiftNumberedBlock", "OpenWashingMachine", "PickAndLiftSmall", "PutAllGroceriesInCupboard", "SetupChess", "StackChairs"),
}


def test_all_106_names_are_classes() -> None:
    """As attributes of `rlbench.tasks`, and in modules of their own that `importlib` finds."""
    assert len(set(KNOWN_TASKS)) == 106
    for name in (*KNOWN_TASKS, *PERACT_TASKS, *gembench_tasks()):
        cls = getattr(tasks, camel_case(name))
        assert issubclass(cls, Task)
        module = importlib.import_module(f"rlbench.tasks.{name}")
        assert getattr(module, camel_case(name)) is cls
        assert getattr(tasks, name) is module
        assert (cls.__module__, cls.__name__) == (f"rlbench.tasks.{name}", camel_case(name))
    assert set(task_names()) == set(KNOWN_TASKS) | set(PERACT_TASKS) | set(gembench_tasks())


def test_import_forms() -> None:
    """`from rlbench.tasks.x import X`, `from rlbench.tasks import *`, `import rlbench.tasks.x`."""
    space: dict[str, object] = {}
    exec("from rlbench.tasks.open_drawer import OpenDrawer\nimport rlbench.tasks.reach_target as module", space)
    assert space["OpenDrawer"] is tasks.OpenDrawer
    assert space["module"].ReachTarget is tasks.ReachTarget  # type: ignore[attr-defined]
    star: dict[str, object] = {}
    exec("from rlbench.tasks import *", star)
    assert {camel_case(name) for name in KNOWN_TASKS} | set(SIZES) <= set(star)
    assert "sys" not in star


def test_tools_list_the_library() -> None:
    """`pkgutil` lists what `TASKS_PATH` lists, the tasks with Python of their own, and each listed module has its class."""
    listed = [module.name for module in pkgutil.iter_modules(tasks.__path__)]
    assert tuple(sorted(listed)) == WITH_PYTHON
    assert all(hasattr(importlib.import_module(f"rlbench.tasks.{name}"), camel_case(name)) for name in listed)


@pytest.mark.simulation
def test_a_module_can_be_reloaded() -> None:
    """As keyframe agents do with the file names of tasks; the new class is as good as the old one."""
    code = (
        "import importlib, rlbench.tasks as t; m = importlib.reload(importlib.import_module('rlbench.tasks.open_drawer')); "
        "print(m.OpenDrawer(None, None).variation_count(), m.OpenDrawer.native_class() is t.OpenDrawer.native_class())"
    )
    done = python("-m", "rlbench_pin.compat", "-c", code)
    assert done.stdout == "3 True\n", done.stderr


def test_task_sets_nest() -> None:
    """Every larger set trains on the whole smaller one; MT sets are the FS sets without a split."""
    for name, sizes in SIZES.items():
        parts = getattr(tasks, name)
        assert tuple(len(parts[part]) for part in parts) == sizes
        assert list(parts) == ["train", "test"][: len(sizes)]
        everything = [cls for part in parts.values() for cls in part]
        assert len(set(everything)) == len(everything) and all(issubclass(cls, Task) for cls in everything)
    for small, large in (("FS10_V1", "FS25_V1"), ("FS25_V1", "FS50_V1"), ("FS50_V1", "FS95_V1")):
        first, second = getattr(tasks, small), getattr(tasks, large)
        assert first["train"] + first["test"] == second["train"][: len(first["train"]) + 5]
    for few, multi in (("FS10_V1", "MT15_V1"), ("FS25_V1", "MT30_V1"), ("FS50_V1", "MT55_V1"), ("FS95_V1", "MT100_V1")):
        assert getattr(tasks, few)["train"] + getattr(tasks, few)["test"] == getattr(tasks, multi)["train"]
    names = {cls.__name__ for cls in tasks.MT100_V1["train"]}
    assert {camel_case(name) for name in KNOWN_TASKS} - names == IN_NO_SET


def test_tasks_path_lists_the_library() -> None:
    """Programs list the folder for task names."""
    listed = [file[:-3] for file in sorted(os.listdir(TASKS_PATH)) if file.endswith(".py") and file != "__init__.py"]
    assert tuple(listed) == WITH_PYTHON
    assert isinstance(TASKS_PATH, str) and Path(TASKS_PATH).is_dir()


def test_a_task_of_the_library_knows_its_variations_before_it_is_loaded() -> None:
    """Name, count of variations and native class need no simulator."""
    for name in task_names():
        cls = getattr(tasks, camel_case(name))
        task = cls(None, None)
        assert task.get_name() == task.name == name
        assert cls.native_class() is task_class(name)
        assert task.variation_count() >= 1
    assert tasks.ReachTarget(None, None).variation_count() == 20
    assert tasks.OpenDrawer(None, None).variation_count() == 3


def test_a_wrong_name_proposes_the_nearest() -> None:
    """As an attribute of `rlbench.tasks`."""
    with pytest.raises(AttributeError, match="Did you mean 'ReachTarget'"):
        getattr(tasks, "ReachTarg" + "te")


@pytest.mark.simulation
def test_importing_the_names_imports_no_task() -> None:
    """Only what is used is read."""
    code = (
        "import sys, rlbench.backend.task, time; began = time.perf_counter(); import rlbench.tasks as t; "
        "spent = time.perf_counter() - began; "
        "print(sum(m.startswith('rlbench_pin.tasks.library.') for m in sys.modules), spent, t.OpenDrawer.__name__)"
    )
    done = python("-c", f"import rlbench_pin.compat as c; c.install(); {code}")
    assert done.returncode == 0, done.stderr
    count, spent, name = done.stdout.split()
    assert (count, name) == ("0", "OpenDrawer")
    assert str(PACKAGES) in sys.path and float(spent) < 2.0
