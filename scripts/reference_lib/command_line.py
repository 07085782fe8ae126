"""The page about the command line, from the parsers of the commands and their exit codes."""

from __future__ import annotations

import argparse
import re
import warnings
from collections.abc import Iterator, Mapping
from typing import Any, get_args, get_type_hints

import tyro

from reference_lib.docs import doc_of, table
from rlbench_pin.cli.interrupts import INTERRUPTED, PIPE_CLOSED
from rlbench_pin.cli.running import COMMANDS, DONE, FAILED, MISUSED

_DEFAULT = re.compile(r" ?\((?:default: (.*)|required|optional)\)$", re.DOTALL)
_NONE = re.compile(r"\{None\}\||(?<=\{)None,")
"""How a parser says that a flag may be left out."""
WITH_ACTIONS = ("dataset", "train", "challenge", "arm")
"""Commands that have a section for each of their actions."""
CODES: Mapping[int, str] = {
    DONE: "Done.",
    FAILED: "Failed: an episode is missing, a task or a file did not pass, something could not be read or written.",
    MISUSED: "Wrong usage: an unknown command, flag, task or value, or a request without work to do.",
    INTERRUPTED: "Interrupted by Ctrl-C. In the first 0.05 s Python itself may exit with 1 or a signal.",
    PIPE_CLOSED: "The reader of the output has ended, as in `rlbench-pin list | head -1`.",
}
"""Exit code -> when a command ends with it."""


def parts() -> dict[str, str]:
    """Return what the page has generated, by marker."""
    made = {name: _section(cls) for name, cls in commands().items()}
    return {"codes": table(("Code", "When"), [(str(code), text) for code, text in CODES.items()], "rl"), **made}


def commands() -> dict[str, type]:
    """Return command, or command and its action with a hyphen -> class."""
    found: dict[str, Any] = {name: command for name, command in COMMANDS.items() if name not in WITH_ACTIONS}
    for name in WITH_ACTIONS:
        for action, word in _subcommands(get_type_hints(COMMANDS[name], include_extras=True)["action"]):
            found[f"{name}-{word}"] = action
    return found


def _subcommands(annotation: Any) -> Iterator[tuple[type, str]]:
    """Yield the classes of an annotation with the words that choose them."""
    for part in get_args(annotation):
        if hasattr(part, "__metadata__"):
            words = [extra.name for extra in part.__metadata__ if hasattr(extra, "name") and extra.name]
            if words:
                yield part.__origin__, words[0]
                continue
        yield from _subcommands(part)


def arguments_of(cls: type) -> list[argparse.Action]:
    """Return what a command takes, as its parser has it; those without a flag first."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        parser = tyro.extras.get_parser(cls)
    actions = [action for action in parser._actions if action.dest != "help"]
    return sorted(actions, key=lambda action: bool(action.option_strings))


def _section(cls: type) -> str:
    doc = doc_of(cls)
    rows = [_row(action) for action in arguments_of(cls)]
    return f"{doc.text}\n\n{table(('Argument', 'Default', 'Meaning'), rows)}"


def _row(action: argparse.Action) -> tuple[str, str, str]:
    metavar = _NONE.sub("", action.metavar if isinstance(action.metavar, str) else "")
    flags = ", ".join(f"`{flag}{' ' + metavar if metavar else ''}`" for flag in action.option_strings) or f"`{metavar}`"
    text = " ".join((action.help or "").split())
    found = _DEFAULT.search(text)
    default = "" if found is None or found[1] in ("", "None") else "required" if found[1] is None else f"`{found[1]}`"
    if isinstance(action.default, bool):
        default = f"`{action.option_strings[0] if action.default else action.option_strings[-1]}`"
    return flags, default, _DEFAULT.sub("", text)
