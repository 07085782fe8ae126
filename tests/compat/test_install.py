"""Who asks finds `rlbench` and `pyrep`, in three ways; who does not ask never does."""

from __future__ import annotations

import os
import site
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.compat.support import ROOT, compat, environment, python

START_FILE = "rlbench_pin_compat.pth"
WHERE = "import importlib.util as u; s = u.find_spec('rlbench'); print(None if s is None else s.origin)"
OURS = str(ROOT / "rlbench_pin" / "compat" / "packages" / "rlbench" / "__init__.py")


@pytest.mark.simulation
def test_the_names_are_not_there_by_default() -> None:
    """Neither rlbench_pin nor its compat package brings them; `install()` does, and a second call changes nothing."""
    said = python("-c", f"import rlbench_pin, rlbench_pin.compat\n{WHERE}")
    assert said.stdout.strip() == "None", said.stderr
    twice = "from rlbench_pin.compat import install; import sys\ninstall(); install(); print(len(sys.path) - len(set(sys.path)))"
    said = python("-c", f"{twice}\n{WHERE}")
    assert said.stdout.split() == ["0", OURS], said.stderr


def test_importing_the_package_stays_cheap() -> None:
    """`import rlbench_pin` loads nothing of the layer."""
    said = python("-c", "import rlbench_pin, sys; print([m for m in sys.modules if 'compat' in m and 'rlbench' in m])")
    assert said.stdout.strip() == "[]", said.stderr


# A real package in the way ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rlbench", "pyrep"])
def test_a_real_package_is_never_shadowed(name: str, tmp_path: Path) -> None:
    """The error names the package, its place, and what to do; it is an ImportError."""
    (tmp_path / name).mkdir()
    (tmp_path / name / "__init__.py").touch()
    env = environment(PYTHONPATH=f"{ROOT}{os.pathsep}{tmp_path}")
    said = python("-c", "from rlbench_pin.compat import install; install()", env=env)
    assert said.returncode == 1
    assert f"RealPackageInstalled: The real '{name}' is installed at {tmp_path / name}" in said.stderr
    assert "import from rlbench_pin" in said.stderr


def test_a_real_package_beside_the_program(tmp_path: Path) -> None:
    """A copy of it in the program's folder would come first, so the command refuses, in one line."""
    (tmp_path / "rlbench").mkdir()
    (tmp_path / "rlbench" / "__init__.py").touch()
    (tmp_path / "program.py").write_text("print('ran')")
    said = compat(tmp_path / "program.py")
    assert (said.returncode, said.stdout) == (1, "")
    assert said.stderr.startswith("python -m rlbench_pin.compat: The real 'rlbench'")
    assert "Traceback" not in said.stderr


# python -m rlbench_pin.compat -------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_help_teaches() -> None:
    """All three ways stand in it; without arguments it is an error."""
    said = compat("--help")
    assert said.returncode == 0
    for way in ("rlbench_pin.compat PROGRAM.py", "RLBENCH_PIN_COMPAT=1 python", "install()"):
        assert way in said.stdout
    said = compat()
    assert (said.returncode, said.stdout) == (2, "")
    assert "usage" in said.stderr


FOUND = "import importlib.util as u; assert u.find_spec('rlbench') and u.find_spec('pyrep')"
ECHO = f"""\
import sys, helper
{FOUND}
print(sys.argv, __name__, __file__, sys.path[0], helper.X, __spec__)
"""


def test_a_program_runs_as_with_plain_python(tmp_path: Path) -> None:
    """The same arguments, names and first folder on the search path."""
    (tmp_path / "helper.py").write_text("X = 3")
    program = tmp_path / "program.py"
    program.write_text(ECHO)
    plain = python(program, "a", "--help", env=environment(PYTHONPATH=f"{ROOT}{os.pathsep}{Path(OURS).parents[1]}"))
    ours = compat(program, "a", "--help")
    assert plain.returncode == ours.returncode == 0, plain.stderr + ours.stderr
    assert ours.stdout == plain.stdout
    assert f"['{program}', 'a', '--help'] __main__" in ours.stdout


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("text", "code", "last"),
    [
        ("import sys; sys.exit(7)", 7, ""),
        ("raise SystemExit('no more')", 1, "no more"),
        (
            "def f():\n    raise ValueError('bad')\ntry:\n    f()\nexcept ValueError as e:\n    raise KeyError('k') from e",
            1,
            "KeyError: 'k'",
        ),
        ("x = = 1", 1, "SyntaxError: invalid syntax"),
        ("import nowhere_to_be_found", 1, "ModuleNotFoundError: No module named 'nowhere_to_be_found'"),
        ("import atexit; atexit.register(lambda: print(len(X))); X = [1]", 0, ""),
    ],
)
def test_exit_codes_and_tracebacks_are_those_of_plain_python(text: str, code: int, last: str, tmp_path: Path) -> None:
    """Byte for byte."""
    program = tmp_path / "program.py"
    program.write_text(text)
    plain, ours = python(program), compat(program)
    assert (ours.returncode, ours.stdout, ours.stderr) == (plain.returncode, plain.stdout, plain.stderr)
    assert ours.returncode == code
    assert ours.stderr.strip().splitlines()[-1:] == ([last] if last else [])


@pytest.mark.simulation
def test_modules_packages_folders_and_text(tmp_path: Path) -> None:
    """`-m module`, `-m package`, `folder` and `-c text` as python takes them."""
    show = f"{FOUND}; import sys; from pathlib import Path; print(Path(sys.argv[0]).name, sys.argv[1:], __name__)"
    (tmp_path / "tool.py").write_text(show)
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "__init__.py").touch()
    (tmp_path / "package" / "__main__.py").write_text(f"from . import __name__ as own\n{show}")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "__main__.py").write_text(show)
    for arguments, first in (
        (("-m", "tool", "x"), "tool.py"),
        (("-m", "package", "x"), "__main__.py"),
        (("folder", "x"), "__main__.py"),
        (("-c", show, "x"), "-c"),
    ):
        said = compat(*arguments, cwd=tmp_path)
        assert said.stdout.strip() == f"{first} ['x'] __main__", said.stderr


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("nothing.py",), "can't open file"),
        (("-m", "nothing_here"), "No module named nothing_here"),
        (("-m", "nothing.here"), "No module named 'nothing'"),
        (("-m",), "needs a module"),
        (("-v", "x.py"), "Unknown option '-v'"),
    ],
)
def test_what_cannot_be_run_says_so(arguments: tuple[str, ...], word: str, tmp_path: Path) -> None:
    """One line and exit code 2."""
    said = compat(*arguments, cwd=tmp_path)
    assert said.returncode == 2
    assert word in said.stderr
    assert len(said.stderr.splitlines()) == 1


SPAWN = """\
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
class Note:
    x = 1
def work(note):
    import rlbench, pyrep
    return rlbench.__name__, note.x
if __name__ == "__main__":
    for method in ("spawn", "forkserver", "fork"):
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as pool:
            print(method, pool.submit(work, Note()).result())
"""


@pytest.mark.simulation
def test_processes_that_a_program_starts_find_the_names(tmp_path: Path) -> None:
    """By all start methods; functions and classes of the program travel to them."""
    (tmp_path / "program.py").write_text(SPAWN)
    said = compat(tmp_path / "program.py")
    assert said.returncode == 0, said.stderr
    assert said.stdout == "".join(f"{method} ('rlbench', 1)\n" for method in ("spawn", "forkserver", "fork"))


# RLBENCH_PIN_COMPAT=1 ---------------------------------------------------------------------------------------------------------


def _build(kind: str, folder: Path) -> zipfile.ZipFile:
    """Build a wheel (`build_wheel`) or what `pip install -e` installs (`build_editable`)."""
    pytest.importorskip("hatchling")
    code = f"import hatchling.build as b; print(b.{kind}({str(folder)!r}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return zipfile.ZipFile(next(folder.glob("*.whl")))


def _environment_with(wheel: zipfile.ZipFile, folder: Path) -> str:
    """Unpack a wheel into a new virtual environment, as pip does, and return its python."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True, timeout=300)
    packages = next(folder.glob("lib/python*/site-packages"))
    wheel.extractall(packages)
    return str(folder / "bin" / "python")


@pytest.mark.simulation
@pytest.mark.parametrize("kind", ["build_wheel", "build_editable"])
def test_the_variable_is_read_when_python_starts(kind: str, tmp_path: Path) -> None:
    """In a wheel and an editable install; only when it is set; without an import of rlbench_pin or numpy."""
    with _build(kind, tmp_path) as wheel:
        assert START_FILE in wheel.namelist()
        executable = _environment_with(wheel, tmp_path / "env")
    bare = {key: value for key, value in environment().items() if key != "PYTHONPATH"}
    loaded = f"{WHERE}\nimport sys; print([m for m in ('rlbench_pin', 'numpy', 'runpy') if m in sys.modules])"
    for value, runpy in (("", "[]"), ("0", "[]"), ("1", "['runpy']")):
        said = python("-c", loaded, env={**bare, "RLBENCH_PIN_COMPAT": value}, executable=executable)
        where, modules = said.stdout.splitlines()
        assert (where == "None") == (value != "1"), said.stderr
        assert (modules, said.stderr) == (runpy, "")
        assert where == "None" or where.endswith("rlbench_pin/compat/packages/rlbench/__init__.py")


def test_a_start_with_a_real_package_says_so_once_and_goes_on(tmp_path: Path) -> None:
    """Python starts, the real package stays what it is, and so does its child's start."""
    (tmp_path / "rlbench").mkdir()
    (tmp_path / "rlbench" / "__init__.py").touch()
    start = f"import site, os; [site.addsitedir({str(ROOT / 'rlbench_pin' / 'compat')!r}) for _ in range(2)]\n"
    env = environment(PYTHONPATH=f"{ROOT}{os.pathsep}{tmp_path}", RLBENCH_PIN_COMPAT="1")
    said = python("-S", "-c", f"{start}{WHERE}", env=env)
    assert said.stdout.strip() == str(tmp_path / "rlbench" / "__init__.py")
    assert said.stderr.count("RLBENCH_PIN_COMPAT: The real 'rlbench' is installed at") == 1, said.stderr
    assert "Traceback" not in said.stderr


def test_the_start_file_is_one_line_that_imports_os_first() -> None:
    """Python executes lines of such files that begin with `import`; the variable is asked before anything else is done."""
    (line,) = (ROOT / "rlbench_pin" / "compat" / START_FILE).read_text().splitlines()
    assert line.startswith('import os; os.environ.get("RLBENCH_PIN_COMPAT", "0") in ("", "0") or ')
    assert "os" in site.__dict__  # loaded at every start, so that the import costs nothing


@pytest.mark.simulation
def test_programs_of_the_first_releases_are_told_what_changed() -> None:
    """They import enumerations of modes; the error shows the way that modes are written now."""
    said = compat("-c", "from rlbench.action_modes import ArmActionMode, ActionMode")
    assert said.returncode == 1
    assert "MoveArmThenGripper(JointVelocity(), Discrete())" in said.stderr
    said = compat("-c", "import rlbench.action_modes as m; print(hasattr(m, 'nothing'))")
    assert said.stdout == "False\n", said.stderr
