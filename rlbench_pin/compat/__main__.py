"""`python -m rlbench_pin.compat program.py`: run a program like plain Python, with `rlbench` and `pyrep` available."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType, TracebackType

from rlbench_pin.compat import RealPackageInstalled, install
from rlbench_pin.compat.startup import VARIABLE

DONE, FAILED, MISUSED, INTERRUPTED = 0, 1, 2, 130

HELP = """\
usage: python -m rlbench_pin.compat PROGRAM.py [ARGUMENT ...]
       python -m rlbench_pin.compat -m MODULE [ARGUMENT ...]
       python -m rlbench_pin.compat -c CODE [ARGUMENT ...]

Run a program that was written for RLBench on rlbench_pin. `import rlbench` and `import pyrep` work in it as it
expects, in the processes that it starts as well; arguments, exit code and tracebacks are those of plain python.

Two other ways, with the same effect:
  RLBENCH_PIN_COMPAT=1 python PROGRAM.py                       where rlbench_pin is installed by pip
  import rlbench_pin.compat; rlbench_pin.compat.install()      in a program or notebook, before `import rlbench`

A call that needs a CoppeliaSim model (.ttm) or a window raises an error that names the alternative.
docs/compatibility.md lists what differs. rlbench_pin itself has a smaller and wider interface: see README.md.
"""


class NotFound(Exception):
    """The program or module cannot be found or read."""


def main(arguments: Sequence[str]) -> int:
    """Run the program of the command-line arguments and return the exit code; `SystemExit` of the program passes through."""
    if not arguments or arguments[0] in ("-h", "--help"):
        (sys.stdout if arguments else sys.stderr).write(HELP)
        return DONE if arguments else MISUSED
    try:
        module, code, rest = _prepare(arguments)
        install()
    except (NotFound, RealPackageInstalled) as error:
        sys.stderr.write(f"python -m rlbench_pin.compat: {error}\n")
        return MISUSED if isinstance(error, NotFound) else FAILED
    os.environ[VARIABLE] = "1"  # for python processes that the program starts
    sys.argv[:] = [module.__dict__.get("__file__", "-c"), *rest]
    sys.modules["__main__"] = module
    return _run(module, code)


def _prepare(arguments: Sequence[str]) -> tuple[ModuleType, str | bytes | CodeType, list[str]]:
    """Return the module `__main__`, its code, and the arguments of the program; set the search path as plain Python does."""
    first, *rest = arguments
    if first in ("-m", "-c"):
        if not rest:
            raise NotFound(f"{first} needs a {'module' if first == '-m' else 'text'}. See --help.")
        name, *rest = rest
        module, code = _module(name) if first == "-m" else (_main_module(None, None), name)
        return module, code, rest
    if first.startswith("-"):
        raise NotFound(f"Unknown option '{first}'; put options of python before -m. See --help.")
    path = Path(first)
    if path.suffix not in (".py", ".pyw") and (path.is_dir() or path.suffix in (".zip", ".pyz")):
        _search_first(first)
        return *_module("__main__", [first]), rest
    try:
        text = path.read_bytes()
    except OSError as error:
        raise NotFound(f"can't open file '{path.absolute()}': {error.strerror}") from error
    _search_first(str(path.resolve().parent))
    return _main_module(None, first), text, rest


def _search_first(folder: str) -> None:
    """Replace the first entry of the search path, the working folder because of `python -m`, by the folder of the program."""
    if not sys.flags.safe_path:
        sys.path[0] = folder


def _main_module(spec: ModuleSpec | None, file: str | None) -> ModuleType:
    """Return an empty module `__main__` with the attributes that Python sets for a module specification or a file."""
    module = ModuleType("__main__")
    module.__spec__ = spec
    if spec is not None:
        module.__package__, module.__loader__ = spec.parent, spec.loader
    elif file is not None:
        module.__package__, module.__loader__ = None, SourceFileLoader("__main__", file)
    if file is not None:
        module.__file__ = file
    return module


def _module(name: str, folders: Sequence[str] | None = None) -> tuple[ModuleType, CodeType]:
    """Return `__main__` and its code for a module or package; `folders` are searched instead of the search path."""
    install()  # before the search, for `-m rlbench.dataset_generator`
    try:
        spec = importlib.util.find_spec(name) if folders is None else PathFinder.find_spec(name, list(folders))
        if spec is not None and spec.submodule_search_locations is not None:
            spec = importlib.util.find_spec(f"{name}.__main__")
    except ModuleNotFoundError as error:
        raise NotFound(f"Error while finding '{name}': {error}") from error
    get_code = None if spec is None else getattr(spec.loader, "get_code", None)
    code = None if spec is None or get_code is None else get_code(spec.name)
    if spec is None or code is None:
        raise NotFound(f"No module named {name if folders is None else f'__main__ in {folders[0]}'}, or nothing to run in it.")
    return _main_module(spec, spec.origin), code


def _run(module: ModuleType, code: str | bytes | CodeType) -> int:
    """Run the code as `__main__`; an error is reported by `sys.excepthook`, without the frames of this file."""
    try:
        if not isinstance(code, CodeType):
            code = compile(code, module.__dict__.get("__file__", "<string>"), "exec", dont_inherit=True)
        exec(code, module.__dict__)
    except SystemExit:
        raise
    except BaseException as error:
        trace: TracebackType | None = error.__traceback__
        own = None if trace is None else trace.tb_next
        sys.excepthook(type(error), error.with_traceback(own), own)
        return INTERRUPTED if isinstance(error, KeyboardInterrupt) else FAILED
    return DONE


if __name__ == "__main__":
    code = main(sys.argv[1:])
    if code != DONE:
        sys.exit(code)
