"""Errors are sent between processes with their evidence, and missing extras name what installs them."""

from __future__ import annotations

import errno
import importlib
import inspect
import multiprocessing
import pickle
import pkgutil
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import rlbench_pin
from rlbench_pin.errors import (
    InfeasibleControl,
    MissingExtra,
    NoIkSolution,
    RlbenchPinError,
    StorageError,
    WaypointError,
    install_hint,
)
from rlbench_pin.processes import WorkerDeath
from rlbench_pin.recording.config import WorkItem
from rlbench_pin.viewer.recording import Problem

SKIPPED = ("rlbench_pin.compat.",)
"""Modules that need the known names, and a program; a test in a process of its own looks at their errors."""
KNOWN_NAMES = ("rlbench", "pyrep")
"""Names that exist after `compat.install()`."""
OPTIONAL = ("ray", "qpsolvers", "torch", "safetensors", "tensorboard", "stable_baselines3", "vla_eval")
"""Libraries of extras without which a module cannot be imported."""
DEATH = WorkerDeath(WorkItem("reach_target", "reach_target", 0, 0, 1, (0,)), "SIGKILL")
# Annotation of an argument -> a value for it.
VALUES: dict[str, object] = {
    "str": "some text",
    "int": 3,
    "float": 0.25,
    "object": np.array([0.5, -1.0]),
    "np.ndarray": np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0]),
    "np.ndarray | None": np.array([0.1, 0.2, 0.4, 0.0, 0.0, 0.0, 1.0]),
    "Path": Path("models/settings.json"),
    "Path | str": Path("data/episode0.h5"),
    "OSError": OSError(errno.ENOSPC, "No space left on device"),
    "Exception": ValueError("why"),
    "Collection[str]": ("reach_target", "push_button"),
    "tuple[str, ...]": ("joint1", "joint2"),
    "Sequence[str]": ["reach_target", "why"],
    "list[str]": ["first", "second"],
    "Sequence[float]": (0.001,),
    "Sequence[tuple[str, str]]": [("hand", "cube")],
    "list[Path]": [Path("a.toml"), Path("b.toml")],
    "Sequence[WorkerDeath]": [DEATH],
    "FaultKind": "crashed",
    "Collection[Path]": (Path("a.toml"), Path("b.py")),
    "Problem | None": Problem("task", 7, "It does not end."),
}


def all_kinds() -> list[type[RlbenchPinError]]:
    """Return every error class of the package, whatever module it is in."""
    for module in pkgutil.walk_packages(rlbench_pin.__path__, "rlbench_pin.", onerror=lambda name: None):
        if not module.name.startswith(SKIPPED) and ".library." not in module.name:
            try:
                importlib.import_module(module.name)
            except MissingExtra as error:
                assert error.library in OPTIONAL
            except ModuleNotFoundError as error:
                assert error.name in KNOWN_NAMES  # see also the test in a process of its own
    found: dict[type[RlbenchPinError], None] = {}
    pending: list[type[RlbenchPinError]] = [RlbenchPinError]
    while pending:
        kind = pending.pop()
        found[kind] = None
        pending += kind.__subclasses__()
    ours = ("rlbench_pin", *KNOWN_NAMES)
    return sorted((k for k in found if k.__module__.split(".")[0] in ours), key=lambda k: (k.__module__, k.__name__))


def example(kind: type[RlbenchPinError]) -> RlbenchPinError:
    """Make an error of a class, with a value for every argument that its `__init__` has."""
    own = next(c for c in kind.__mro__ if "__init__" in vars(c))
    if not issubclass(own, RlbenchPinError):
        return kind("What went wrong, and what to do.")
    parameters = list(inspect.signature(kind).parameters.values())
    unknown = [p.annotation for p in parameters if str(p.annotation) not in VALUES]
    assert not unknown, f"{kind.__name__}: add a value for {unknown} to VALUES"
    return kind(*(VALUES[str(p.annotation)] for p in parameters))


def same(one: object, other: object) -> bool:
    """Whether two pieces of evidence say the same."""
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and np.array_equal(one, other)
    if isinstance(one, BaseException):
        return type(one) is type(other) and one.args == getattr(other, "args", None)
    return type(one) is type(other) and one == other


def check_same(error: RlbenchPinError, again: RlbenchPinError) -> None:
    """Compare class, text, arguments and evidence."""
    assert type(again) is type(error)
    assert (str(again), again.args) == (str(error), error.args) and str(error)
    assert vars(again).keys() == vars(error).keys()
    assert [name for name, value in vars(error).items() if not same(value, vars(again)[name])] == []


def raising(module: str, name: str) -> None:
    """Raise the example of an error class; called in another process."""
    raise example(getattr(importlib.import_module(module), name))


@pytest.fixture(scope="module")
def kinds() -> list[type[RlbenchPinError]]:
    """All error classes but those of the known names, which another test of this process may have loaded."""
    others = ("rlbench_pin.compat", "rlbench.", "pyrep.", "tests.")
    return [kind for kind in all_kinds() if not kind.__module__.startswith(others)]


def check_all_protocols(kinds: list[type[RlbenchPinError]]) -> None:
    """Send an example of each class through every protocol of pickle."""
    for kind in kinds:
        error = example(kind)
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            check_same(error, pickle.loads(pickle.dumps(error, protocol)))


def test_every_error_comes_back_from_pickle_as_it_was(kinds: list[type[RlbenchPinError]]) -> None:
    """With its evidence, also where it is an ImportError or an OSError as well."""
    assert len(kinds) > 45
    check_all_protocols(kinds)


@pytest.mark.simulation
def test_so_do_the_errors_of_known_names() -> None:
    """Those that programs written for RLBench catch, in a process where their names exist."""
    lines = (
        "import rlbench_pin.compat; rlbench_pin.compat.install()",
        "import pyrep.errors, rlbench.gym, rlbench.environment, pyrep.backend",
        "from tests.test_errors import all_kinds, check_all_protocols",
        "kinds = all_kinds(); check_all_protocols(kinds)",
        "print(sorted(k.__name__ for k in kinds if k.__module__.split('.')[0] in ('rlbench', 'pyrep')))",
    )
    done = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert "IKError" in done.stdout and "UnknownTaskName" in done.stdout


@pytest.mark.simulation
def test_every_error_comes_back_from_a_pool(kinds: list[type[RlbenchPinError]]) -> None:
    """What a worker raises is raised here; nothing waits for ever."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        for kind in kinds:
            with pytest.raises(kind) as raised:
                pool.apply_async(raising, (kind.__module__, kind.__name__)).get(timeout=60.0)
            check_same(example(kind), raised.value)


class Stuck:
    """Belongs to this process."""

    def __reduce__(self) -> str:
        raise TypeError("stays here")

    def __str__(self) -> str:
        return "the arm of that world"


STUCK = (WaypointError("No waypoint 'waypoint0'.", Stuck()), InfeasibleControl("DifferentialIK", "no room", [Stuck(), 1]))


@pytest.mark.parametrize("error", STUCK, ids=lambda e: type(e).__name__)
def test_evidence_that_stays_behind_arrives_as_text(error: RlbenchPinError) -> None:
    """A running task cannot be pickled: the error still can."""
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again)) == (type(error), str(error))
    assert "the arm of that world" in str(vars(again))


def test_an_error_can_be_caught_and_used_on_the_other_side() -> None:
    """Attributes and properties work as where it was raised."""
    pose = np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0])
    unreachable = pickle.loads(pickle.dumps(NoIkSolution(pose, 0.01, 0.2, 16)))
    assert np.array_equal(unreachable.evidence["pose"], pose)
    full = pickle.loads(pickle.dumps(StorageError("data", OSError(errno.ENOSPC, "No space left on device"))))
    assert (full.path, full.errno) == (Path("data"), errno.ENOSPC)


ROOT = Path(__file__).resolve().parents[1]
EXTRAS = set(tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"])
TEXTS = [
    *ROOT.glob("*.md"),
    *(ROOT / "docs").rglob("*.md"),
    *(file for folder in ("rlbench_pin", "examples", "scripts") for file in (ROOT / folder).rglob("*.py")),
]


def test_the_hint_installs_from_a_clone() -> None:
    """The package is on no index, so its name alone would find nothing; every error has the same text."""
    assert install_hint("rl") == "`pip install -e '.[rl]'` in a clone of rlbench_pin"
    assert str(MissingExtra("This", "torch", "rl")).endswith(f"which is not installed. Install it with {install_hint('rl')}.")


def test_pages_and_programs_say_the_same() -> None:
    """No page asks an index for `rlbench-pin[...]`, and every extra that one names is there."""
    said = {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in TEXTS}
    wrong = r"pip install (?:-U |--upgrade )?['\"]?rlbench[-_]pin"
    assert [name for name, text in said.items() if re.search(wrong, text)] == []
    named = {extra for text in said.values() for extra in re.findall(r"'\.\[(\w+)\]'", text)}
    assert {"rl", "human", "lerobot", "zarr", "ray"} <= named
    assert named <= EXTRAS


@pytest.mark.parametrize(
    ("door", "name", "library"), [("recording", "RayEngine", "ray"), ("control", "ForeignSolver", "qpsolvers")]
)
def test_names_that_need_an_extra_say_so(door: str, name: str, library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are looked up when first used, so that the rest of their package works without."""
    monkeypatch.setitem(sys.modules, library, None)
    for module in ("rlbench_pin.processes.ray_engine", "rlbench_pin.control.qp.foreign_solver"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    package = getattr(rlbench_pin, door)
    monkeypatch.delitem(vars(package), name, raising=False)
    with pytest.raises(MissingExtra, match=f"needs '{library}'.*in a clone"):
        getattr(package, name)
