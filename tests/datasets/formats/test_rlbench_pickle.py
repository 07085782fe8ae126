"""The pickles of RLBench-style folders: other packages load ours, and a hostile one runs nothing here."""

from __future__ import annotations

import ast
import os
import pickle
import pickletools
import resource
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.datasets import DatasetWriter
from rlbench_pin.datasets.formats.rlbench import export_rlbench, read_folder, write_frames
from rlbench_pin.datasets.formats.rlbench_pickle import PickledObservation, dump, load
from rlbench_pin.environment.observations.observe import spread_mask
from rlbench_pin.errors import EpisodeFileError
from tests.datasets.formats.test_rlbench_folders import make_demo

TASK = "reach_target"


@pytest.fixture(scope="module")
def episode(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of one exported episode, of seed 3."""
    data, out = tmp_path_factory.mktemp("data"), tmp_path_factory.mktemp("folders") / "x"
    DatasetWriter(data).add(make_demo(3))
    return export_rlbench(data, out) / TASK / "variation0" / "episodes" / "episode0"


def test_other_packages_load_the_pickle(episode: Path, tmp_path: Path) -> None:
    """A plain unpickler that has classes under the upstream names, and nothing of ours, gets their instances."""
    package = tmp_path / "site" / "rlbench" / "backend"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").write_text("")
    (package / "__init__.py").write_text("")
    (package.parent / "demo.py").write_text("class Demo:\n    def __len__(self):\n        return len(self._observations)\n")
    (package / "observation.py").write_text("class Observation:\n    pass\n")
    code = (
        "import pickle, sys\n"
        "demo = pickle.load(open(sys.argv[1], 'rb'))\n"
        "first = demo._observations[0]\n"
        "print(type(demo).__module__, type(first).__module__, len(demo), first.front_rgb, first.joint_positions.shape,"
        " demo.random_seed, first.misc['variation_index'], any('rlbench_pin' in m for m in sys.modules))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    command = [sys.executable, "-W", "ignore", "-c", code, str(episode / "low_dim_obs.pkl")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=True)
    assert done.stdout.split() == ["rlbench.demo", "rlbench.backend.observation", "4", "None", "(7,)", "3", "0", "False"]


def test_the_pickle_names_nothing_of_ours(episode: Path, tmp_path: Path) -> None:
    """Every name in the file is one that the package of the format, or any numpy, knows."""
    data = (episode / "low_dim_obs.pkl").read_bytes()
    names = {str(argument) for opcode, argument, _ in pickletools.genops(data) if opcode.name == "GLOBAL"}
    assert names <= {
        "rlbench.demo Demo", "rlbench.backend.observation Observation", "numpy.core.multiarray _reconstruct",
        "numpy.core.multiarray scalar", "numpy ndarray", "numpy dtype", "_codecs encode", "copy_reg _reconstructor",
        "__builtin__ object",
    }  # fmt: skip


_CLASSES = (("demo", "Demo"), ("backend.observation", "Observation"))


class Evil:
    """Runs a command when it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Any, ...]:
        return os.system, (f"touch {self.file}",)


@pytest.mark.parametrize("protocol", range(6))
def test_a_hostile_pickle_runs_nothing(tmp_path: Path, protocol: int) -> None:
    """A file that asks for a function is refused by name, before the function is called."""
    bad = tmp_path / "low_dim_obs.pkl"
    bad.write_bytes(pickle.dumps(Evil(tmp_path / "pwned"), protocol=protocol))
    with pytest.raises(EpisodeFileError, match=r"low_dim_obs\.pkl.*system.*Do not trust it"):
        load(bad)
    assert not (tmp_path / "pwned").exists()


@pytest.mark.parametrize(
    "data",
    [
        b"cbuiltins\neval\n(S'1'\ntR.",
        b"cbuiltins\ngetattr\n(cbuiltins\nobject\nS'__subclasses__'\ntR.",
        b"crlbench_pin.datasets.formats.rlbench_pickle\nload\n.",
        b"cnumpy\nload\n(S'/etc/passwd'\ntR.",
        b"cnumpy.core.multiarray\nfromfile\n.",
        b"c_codecs\nencode\n(Vx\nVzlib\ntR.",
        b"Psomething\n.",
        b"cnumpy\nndarray\n((K\x01tVO\ntR.",
        b"cnumpy\ndtype\n(VV8\ntR.",
        b"cnumpy.core.multiarray\nscalar\n(cnumpy\ndtype\n(VO\ntRC\x08AAAAAAAAtR.",
        b"",
        b"\x80\x04garbage",
    ],
)
def test_damaged_and_hostile_bytes_are_named(tmp_path: Path, data: bytes) -> None:
    """Whatever the bytes are, the error is ours and names the file."""
    (tmp_path / "x.pkl").write_bytes(data)
    with pytest.raises(EpisodeFileError, match=r"x\.pkl"):
        load(tmp_path / "x.pkl")


@pytest.mark.parametrize("protocol", range(6))
def test_pickles_of_every_protocol_are_read(tmp_path: Path, protocol: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of other Pythons and numpys hold the same things in other words."""
    for module in ("rlbench", "rlbench.backend", "rlbench.demo", "rlbench.backend.observation"):
        monkeypatch.setitem(sys.modules, module, types.ModuleType(module))
    classes = [type(name, (), {"__module__": f"rlbench.{module}"}) for module, name in _CLASSES]
    for cls in classes:
        setattr(sys.modules[cls.__module__], cls.__name__, cls)
    demo, observation = (cls() for cls in classes)
    observation.__dict__.update(joint_positions=np.arange(7.0), gripper_open=np.float64(1.0), misc={"x": np.int32(4), "s": "é"})
    observation.__dict__.update(task_low_dim_state=np.zeros(0))
    demo.__dict__.update(_observations=[observation], random_seed=("MT19937", np.arange(4, dtype=np.uint32), 624, 0, 0.0))
    data = pickle.dumps(demo, protocol=protocol)
    (tmp_path / "x.pkl").write_bytes(data)
    again = load(tmp_path / "x.pkl")
    (first,) = vars(again)["_observations"]
    assert np.array_equal(vars(first)["joint_positions"], np.arange(7.0))
    assert (vars(first)["gripper_open"], vars(first)["misc"]) == (1.0, {"x": 4, "s": "é"})
    assert vars(first)["task_low_dim_state"].shape == (0,)


@pytest.mark.simulation
@pytest.mark.parametrize("protocol", [2, 4, 5])
def test_a_live_demo_that_a_program_pickled_is_read(tmp_path: Path, protocol: int) -> None:
    """With its snapshot of the world and the try of its seed; `write_frames` keeps the try as well."""
    demo = make_demo(5)
    demo.state, demo.attempt = {"joints": np.arange(3.0)}, 2
    by_hand = tmp_path / TASK / "variation0" / "episodes" / "episode0"
    by_hand.mkdir(parents=True)
    (by_hand / "low_dim_obs.pkl").write_bytes(pickle.dumps(demo, protocol=protocol))
    read = read_folder(by_hand)
    assert (read.random_seed, read.attempt, len(read)) == (5, 2, 4)
    assert read.state is not None and np.array_equal(read.state["joints"], [0.0, 1.0, 2.0])
    assert np.array_equal(read[1].joint_positions, demo[1].joint_positions)  # type: ignore[arg-type]
    written = by_hand.with_name("episode1")
    write_frames(written, demo)
    assert read_folder(written).attempt == 2


def test_masks_over_three_channels_are_written(tmp_path: Path) -> None:
    """As floats in 0..1, they become the same images as ids."""
    demo = make_demo(6)
    ids = [frame.front_mask for frame in demo]
    for frame in demo:
        assert frame.front_mask is not None
        frame.front_mask = spread_mask(frame.front_mask)
    folder = tmp_path / TASK / "variation0" / "episodes" / "episode0"
    write_frames(folder, demo)
    assert all(np.array_equal(a.front_mask, b) for a, b in zip(read_folder(folder), ids))  # type: ignore[arg-type]


@pytest.mark.simulation
def test_pickle_has_one_home() -> None:
    """No module but the one for this foreign format reads pickles; errors ask pickle whether their evidence can travel."""
    package = Path(__file__).parents[3] / "rlbench_pin"
    importing = {
        file.name
        for file in package.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Import)
        and any(alias.name in ("pickle", "dill", "cloudpickle", "marshal") for alias in node.names)
    }
    assert importing == {"rlbench_pickle.py", "errors.py"}
    assert "pickle.load(" not in (package / "errors.py").read_text(encoding="utf-8")


BOMBS = {
    "room for notes": b"\x80\x02]r\x00\x00\x00\x04.",
    "room for notes, in words": b"\x80\x02]p60000000\n.",
    "an array of zeros": b"cnumpy.core.numeric\n_frombuffer\n(J\xff\xff\xff\x7fcnumpy\ndtype\n(Vu1\ntRJ\xff\xff\xff\x7fVC\ntR.",
}


@pytest.mark.parametrize("data", BOMBS.values(), ids=BOMBS.keys())
def test_a_few_bytes_do_not_fill_the_memory(tmp_path: Path, data: bytes) -> None:
    """What asks for room that its size cannot need is refused before it has it."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    (tmp_path / "low_dim_obs.pkl").write_bytes(data)
    with pytest.raises(EpisodeFileError, match=r"low_dim_obs\.pkl"):
        load(tmp_path / "low_dim_obs.pkl")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + 200_000  # [kB]


def test_a_few_bytes_do_not_take_for_ever(tmp_path: Path) -> None:
    """A pair of pairs of pairs, forty deep, is looked at forty times, not 2**40 times."""
    path = tmp_path / "low_dim_obs.pkl"
    path.write_bytes(b"\x80\x02)" + b"2\x86" * 40 + b".")
    found = load(path)
    assert len(found) == 2 and found[0] is found[1]


def test_a_variation_that_is_no_number_is_named(tmp_path: Path) -> None:
    """The folder does not say which it is, and the first frame says a word."""
    observation = PickledObservation()
    observation.__dict__.update(misc={"variation_index": "third"})
    folder = tmp_path / "task" / "somewhere" / "episodes" / "episode0"
    folder.mkdir(parents=True)
    (folder / "low_dim_obs.pkl").write_bytes(dump([observation]))
    with pytest.raises(EpisodeFileError, match="has the variation 'third'"):
        read_folder(folder)
