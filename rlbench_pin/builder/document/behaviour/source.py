"""The text of a task's Python file with its syntax tree: where each part of it stands in the text."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from functools import cached_property

Function = ast.FunctionDef | ast.AsyncFunctionDef
Replacement = tuple[int, int, str]


class PythonSyntaxError(ValueError):
    """A text is no Python; says in which line and why."""

    def __init__(self, line: int | None, problem: str) -> None:
        self.line, self.problem = line, problem
        super().__init__(f"line {line}: {problem}" if line else problem)


class Source:
    """A Python text and its tree.

    Args:
        text: Content of a `.py` file.

    Raises:
        PythonSyntaxError: It is no Python.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        try:
            self.tree = ast.parse(text)
        except SyntaxError as error:
            raise PythonSyntaxError(error.lineno, error.msg) from error
        except (ValueError, RecursionError, MemoryError) as error:
            raise PythonSyntaxError(None, str(error) or "it is nested too deeply") from error

    @cached_property
    def _starts(self) -> list[int]:
        starts = [0]
        for line in _lines(self.text):
            starts.append(starts[-1] + len(line))
        return starts

    def place(self, line: int, column: int) -> int:
        """Return the place in the text of a line, from 1, and a column in bytes, as trees have them."""
        start = self._starts[line - 1]
        words = self.text[start : self._starts[line]] if line < len(self._starts) else ""
        return start + (column if words.isascii() else len(words.encode()[:column].decode(errors="ignore")))

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Return where a part of the tree begins and ends."""
        first: int = node.lineno  # type: ignore[attr-defined]
        return self.place(first, node.col_offset), self.place(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]

    def part(self, node: ast.AST) -> str:
        """Return the text of a part of the tree."""
        start, end = self.span(node)
        return self.text[start:end]

    def line_span(self, node: ast.stmt) -> tuple[int, int]:
        """Return where the lines of a statement begin and end, decorators included."""
        decorators = getattr(node, "decorator_list", [])
        first = min([node.lineno, *(decorator.lineno for decorator in decorators)])
        return self._starts[first - 1], self._starts[node.end_lineno or node.lineno]

    def line(self, number: int) -> str:
        """Return a line, from 1, without its end."""
        return self.text[self._starts[number - 1] : self._starts[number]].rstrip("\n")

    @property
    def line_count(self) -> int:
        """How many lines there are."""
        return len(self._starts) - 1

    def edited(self, replacements: Iterable[Replacement]) -> str:
        """Return the text with places of it replaced."""
        text = self.text
        for start, end, new in sorted(replacements, reverse=True):
            text = f"{text[:start]}{new}{text[end:]}"
        return text


def text_of(node: ast.AST | None) -> str | None:
    """Return the value of a text that is written out, None when it is none."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def texts_of(tree: ast.AST) -> Iterator[tuple[ast.Constant, str]]:
    """Yield the texts of a tree, with what they say; docstrings and the fixed parts of f-strings are not among them."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            skipped.add(id(node.value))
        if isinstance(node, ast.JoinedStr):
            skipped |= {id(part) for part in node.values if isinstance(part, ast.Constant)}
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skipped:
            yield node, node.value


def _lines(text: str) -> list[str]:
    """Split at line feeds alone, as Python counts lines."""
    return [f"{line}\n" for line in text.split("\n")[:-1]] + [text.split("\n")[-1]]
