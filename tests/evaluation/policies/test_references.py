"""What policies are called leads to them, or to an error that says what there is, before anything of theirs runs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rlbench_pin.errors import MissingExtra, RlbenchPinError, UnknownName
from rlbench_pin.evaluation.policies import LibraryMissing, Noop, PolicyReferenceError, find_policy, open_policy
from rlbench_pin.evaluation.policies.policy_server import NoPolicy
from rlbench_pin.evaluation.policies.references import make_policy, split_reference
from tests.evaluation.policies.test_faults import FILE

MODULE = "tests.evaluation.policies.policies_for_tests"


@pytest.mark.parametrize(
    ("reference", "place"),
    [
        ("noop", "in-process"),
        ("random", "in-process"),
        (f"{FILE}:Obedient", "subprocess"),
        (f"{FILE}:Obedient?scale=3&name=a", "subprocess"),
        (f"{MODULE}:Obedient", "subprocess"),
        (f"{MODULE}:INSTANCE", "subprocess"),
        ("unix:/nowhere", "socket"),
        ("tcp://localhost:80", "socket"),
        ("openpi://localhost:80?mapping=libero&replan=5", "websocket"),
        ("vla-eval://[::1]:80?mapping=peract&token=a", "websocket"),
    ],
)
def test_what_there_is_is_found(reference: str, place: str) -> None:
    """Nothing starts: a server need not be there yet."""
    assert find_policy(reference).place == place
    open_policy(reference)


@pytest.mark.parametrize(
    ("reference", "kind", "says"),
    [
        ("radnom", UnknownName, "Did you mean 'random'"),
        ("", PolicyReferenceError, "has to be a text"),
        ("a\0b:c", PolicyReferenceError, "has to be a text"),
        ("expert", PolicyReferenceError, "it is not available as an object"),
        ("no_such_module:make", PolicyReferenceError, "needs the module .*, which does not exist"),
        ("rlbench_pin.no_such:make", PolicyReferenceError, "needs the module .*, which does not exist"),
        (f"{MODULE}.deeper:make", PolicyReferenceError, "needs the module .*, which does not exist"),
        (f"{MODULE}:Obediant", PolicyReferenceError, "Did you mean 'Obedient'"),
        (f"{FILE}:Obediant", PolicyReferenceError, "Did you mean 'Obedient'"),
        (f"{FILE}:not a name", PolicyReferenceError, "has an unknown form"),
        (f"{FILE}:Obedient?scale", PolicyReferenceError, "key=value"),
        (f"{FILE}:Obedient?a=1&a=2", PolicyReferenceError, "each key once"),
        ("missing.py:make", PolicyReferenceError, "needs the file .*, which does not exist"),
        ("..:make", PolicyReferenceError, "needs the module .*, which does not exist"),
        (":make", PolicyReferenceError, "has an unknown form"),
        ("unix:", PolicyReferenceError, "needs the path"),
        ("tcp://localhost", PolicyReferenceError, "is not an address"),
        ("tcp://localhost:port", PolicyReferenceError, "is not an address"),
        ("sb3:missing.zip", PolicyReferenceError, "model.save"),
        ("lerobot:missing", PolicyReferenceError, "config.json"),
        (f"{'x' * 5000}.py:make", PolicyReferenceError, "needs the file .*, which does not exist"),
        (f"{'x' * 5000}:make", PolicyReferenceError, "needs the module .*, which does not exist"),
        (f"lerobot:{'x' * 5000}", PolicyReferenceError, "config.json"),
        (f"sb3:{'x' * 5000}", PolicyReferenceError, "model.save"),
        ("noop?speed=3", PolicyReferenceError, "does not accept these arguments"),
    ],
)
def test_what_there_is_not_is_refused(reference: str, kind: type[RlbenchPinError], says: str) -> None:
    """Each by an error with the next step."""
    with pytest.raises(kind, match=says):
        open_policy(reference)


@pytest.mark.parametrize("thing", [None, 7, object(), Noop, [Noop()]])
def test_things_that_are_no_policy_are_refused(thing: object) -> None:
    """A class is none either; an object of it is."""
    with pytest.raises(PolicyReferenceError, match="has to be an object with reset"):
        open_policy(thing)  # type: ignore[arg-type]
    open_policy(Noop())


@pytest.mark.parametrize("limit", [0.0, -1.0, float("nan"), float("inf"), "5"])
def test_wrong_limits_are_refused(limit: float) -> None:
    """Times are numbers above zero."""
    for name in ("time_limit", "start_limit"):
        with pytest.raises(RlbenchPinError, match=name):
            open_policy("noop", **{name: limit})  # type: ignore[arg-type]


def test_nothing_is_run_to_look(tmp_path: Path) -> None:
    """Neither a file, nor a package on the way to a module; a syntax error is found all the same."""
    (tmp_path / "loud").mkdir()
    (tmp_path / "loud" / "__init__.py").write_text("raise SystemExit('it ran')")
    (tmp_path / "loud" / "inner.py").write_text("def make(): ...\nraise SystemExit('it ran')")
    (tmp_path / "wrong.py").write_text("def make(:")
    sys.path.insert(0, str(tmp_path))
    try:
        assert find_policy("loud.inner:make").place == "subprocess"
    finally:
        sys.path.remove(str(tmp_path))
    assert find_policy(f"{tmp_path}/loud/inner.py:make").place == "subprocess"
    with pytest.raises(PolicyReferenceError, match="cannot be read"):
        find_policy(f"{tmp_path}/wrong.py:make")


def test_libraries_that_are_not_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says what brings them, or how to do without."""
    (tmp_path / "config.json").write_text("{}")
    (tmp_path / "model.zip").write_bytes(b"")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(LibraryMissing, match="Serve the policy from a Python environment with it"):
        find_policy(f"lerobot:{tmp_path}")
    with pytest.raises(MissingExtra, match="rl"):
        find_policy(f"sb3:{tmp_path}/model")


def test_arguments_are_json_or_text() -> None:
    """Numbers, switches and lists have their kind; anything else is text."""
    where, name, arguments = split_reference("a.b:make?n=3&x=0.5&on=true&who=Ann&list=[1,2]&path=/a%20b&empty=")
    assert (where, name) == ("a.b", "make")
    assert arguments == {"n": 3, "x": 0.5, "on": True, "who": "Ann", "list": [1, 2], "path": "/a b", "empty": ""}


def test_a_file_finds_its_neighbours(tmp_path: Path) -> None:
    """As a program does that lies there; what it lacks is said."""
    (tmp_path / "neighbour_of_policy.py").write_text("SCALE = 3.0")
    (tmp_path / "its_policy.py").write_text(
        "from neighbour_of_policy import SCALE\nfrom tests.evaluation.policies.policies_for_tests import Obedient\n"
        "def make():\n    return Obedient(SCALE)\n"
    )
    before = list(sys.path)
    try:
        assert make_policy(f"{tmp_path}/its_policy.py:make").scale == 3.0
        with pytest.raises(NoPolicy, match="has no 'other'"):
            make_policy(f"{tmp_path}/its_policy.py:other")
    finally:
        sys.path[:] = before
