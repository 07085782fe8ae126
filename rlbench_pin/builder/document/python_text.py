"""The Python file of a task as text with its syntax tree: positions, layout of expressions, imports, and names of the scene.

`ast` provides the positions. `libcst` needs 10 to 100 ms for the positions of one task, and an edit reads the text several times.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from rlbench_pin import tasks
from rlbench_pin.builder.document.texts import Replacement, replaced

Function = ast.FunctionDef | ast.AsyncFunctionDef
ListNode = ast.List | ast.Tuple
INDENT = "    "
_MAX_LINE_LENGTH = 130
_MAX_DEPTH = 100
"""Maximum depth of a syntax tree."""
LOOKUPS = ("body", "joint", "frame", "region", "sensor")
"""Methods of the world that look up an element by name, such as `self.world.body(name)`."""
_BY_NUMBER = frozenset(
    {
        "register_waypoint_ability_start",
        "register_waypoint_ability_end",
        "register_stop_at_waypoint",
        "get_waypoint",
    }
)
"""Calls whose first argument is the number of a waypoint."""
_LINE_END = r"\r\n?|\n"
_WAYPOINT = re.compile(r"waypoint(\d+)")
_VOCABULARY = "rlbench_pin.tasks"


class PythonSyntaxError(ValueError):
    """A text is not valid Python; the message names the line and the cause."""

    def __init__(self, line: int | None, problem: str) -> None:
        self.line, self.problem = line, problem
        super().__init__(f"line {line}: {problem}" if line else problem)


class Source:
    """A Python text and its syntax tree.

    Raises:
        PythonSyntaxError: The text is not valid Python.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        try:
            self.tree = ast.parse(text)
        except SyntaxError as error:
            raise PythonSyntaxError(error.lineno, error.msg) from error
        except (ValueError, RecursionError, MemoryError) as error:
            raise PythonSyntaxError(None, str(error) or "it is nested too deeply") from error
        level: list[ast.AST] = [self.tree]
        for _ in range(_MAX_DEPTH):
            level = [child for node in level for child in ast.iter_child_nodes(node)]
        if deep := next((node for node in level if isinstance(node, ast.expr | ast.stmt)), None):
            raise PythonSyntaxError(deep.lineno, "it is nested too deeply")

    @cached_property
    def _starts(self) -> list[int]:
        """Start positions of the lines, as Python counts them, and the end of the text."""
        return [0, *(found.end() for found in re.finditer(_LINE_END, self.text)), len(self.text)]

    def _place(self, line: int, column: int) -> int:
        """Return the position in the text of a line and a column in bytes."""
        start, end = self._starts[line - 1 : line + 1]
        words = self.text[start:end]
        return start + (column if words.isascii() else len(words.encode()[:column].decode(errors="ignore")))

    def span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        """Return the start and end of a part of the tree in the text."""
        assert node.end_lineno is not None and node.end_col_offset is not None
        return self._place(node.lineno, node.col_offset), self._place(node.end_lineno, node.end_col_offset)

    def part(self, node: ast.expr | ast.stmt) -> str:
        return self.text[slice(*self.span(node))]

    def line_span(self, node: ast.stmt) -> tuple[int, int]:
        """Return the start and end of the lines of a statement, decorators included."""
        first = min([node.lineno, *(decorator.lineno for decorator in getattr(node, "decorator_list", []))])
        return self._starts[first - 1], self._starts[node.end_lineno or node.lineno]

    @cached_property
    def lines(self) -> list[str]:
        """The lines without their ends."""
        return re.split(_LINE_END, self.text)

    def edited(self, replacements: Iterable[Replacement]) -> str:
        return replaced(self.text, replacements)

    def without(self, statement: ast.stmt) -> Replacement:
        """Return the replacement that removes the lines of a statement."""
        return (*self.line_span(statement), "")

    def above(self, statement: ast.stmt, text: str) -> Replacement:
        """Return the replacement that inserts lines above a statement."""
        start, _ = self.line_span(statement)
        return start, start, text

    def below(self, statement: ast.stmt, text: str) -> Replacement:
        """Return the replacement that inserts lines below a statement."""
        _, end = self.line_span(statement)
        return end, end, text if self.text[:end].endswith("\n") else f"\n{text}"

    def indent_before(self, place: int) -> str:
        """Return the text of a line up to a position."""
        return self.text[self.text.rfind("\n", 0, place) + 1 : place]

    def new_list(self, node: ListNode, new: Sequence[str]) -> list[Replacement]:
        """Return the replacements for new items of a list; items that keep their positions stay byte-identical."""
        old = [self.part(item) for item in node.elts]
        if len(old) == len(new):
            changed = [(*self.span(item), b) for item, a, b in zip(node.elts, old, new, strict=True) if a != b]
            if all(self._fits(*replacement) for replacement in changed):
                return changed
        start, end = self.span(node)
        before = self.indent_before(start)
        indent = before[: len(before) - len(before.lstrip())]
        brackets = "()" if isinstance(node, ast.Tuple) else "[]"
        return [(start, end, listed(new, indent, len(before), self._line_end(end) - end, brackets))]

    def _fits(self, start: int, end: int, new: str) -> bool:
        return len(self.indent_before(start)) + len(new) + self._line_end(end) - end <= _MAX_LINE_LENGTH

    def _line_end(self, place: int) -> int:
        end = self.text.find("\n", place)
        return end if end >= 0 else len(self.text)


def source_or_none(text: str) -> Source | None:
    try:
        return Source(text)
    except PythonSyntaxError:
        return None


def text_of(node: ast.AST | None) -> str | None:
    """Return the value of a string literal, None for anything else."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


# The class of a task ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Binding:
    """The value of a name that is assigned once; `is_alone` when the statement assigns nothing else."""

    value: ast.expr
    statement: ast.stmt
    is_alone: bool


class TaskClass:
    """The class of a task: the only one in its file that has `init_task`."""

    def __init__(self, source: Source, node: ast.ClassDef, init: Function) -> None:
        self.source, self.node, self.init = source, node, init
        self.init_indent = " " * init.body[0].col_offset

    @classmethod
    def of(cls, source: Source) -> TaskClass | None:
        """Return the class that has `init_task`; None when there is none, or more than one."""
        classes = [node for node in source.tree.body if isinstance(node, ast.ClassDef)]
        found = [(node, init) for node in classes if (init := _method(node, "init_task")) is not None]
        return cls(source, *found[0]) if len(found) == 1 else None

    def method(self, name: str) -> Function | None:
        return _method(self.node, name)

    def calls(self, name: str) -> list[ast.Call]:
        """Return the calls of a method of the task, `self.<name>(...)`, anywhere in the class."""
        return [node for node in ast.walk(self.node) if isinstance(node, ast.Call) and is_own(node.func, name)]

    def function_around(self, node: ast.AST) -> Function | None:
        """Return the method that contains a part of the tree."""
        methods = [function for function in self.node.body if isinstance(function, Function)]
        return next((function for function in methods if any(part is node for part in ast.walk(function))), None)

    def bindings(self, function: Function | None) -> dict[str, Binding]:
        """Return the values of names in a method: constants, attributes from `init_task`, local names."""
        local = dict(_once(_assignments(function.body), function)) if function is not None else {}
        return {**self._own_names, **{name: bound for name, bound in local.items() if "." not in name}}

    @cached_property
    def _own_names(self) -> dict[str, Binding]:
        constants = dict(_once(_assignments(self.source.tree.body), self.source.tree))
        own = {f"self.{name}": bound for name, bound in _once(_assignments(self.node.body), self.node)}
        kept = dict(_once(_assignments(self.init.body), self.node))
        return {**constants, **own, **{name: bound for name, bound in kept.items() if name.startswith("self.")}}

    def into_init(self, text: str) -> Replacement:
        """Return the replacement that inserts lines into `init_task`: above the first registration, or at its end."""
        for statement in body_of(self.init):
            if isinstance(statement, ast.Expr) and ast.unparse(statement).startswith("self.register_"):
                return self.source.above(statement, text)
        return self.source.below(self.init.body[-1], text)


def is_own(node: ast.expr, name: str) -> bool:
    """Return whether an expression is `self.<name>`."""
    return isinstance(node, ast.Attribute) and node.attr == name and isinstance(node.value, ast.Name) and node.value.id == "self"


def body_of(function: Function) -> list[ast.stmt]:
    """Return the statements of a method after its docstring."""
    return function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body


def only_return(method: Function) -> ast.Return | None:
    """Return the last statement of a method if it is the only `return`, otherwise None."""
    returns = [node for node in ast.walk(method) if isinstance(node, ast.Return)]
    body = body_of(method)
    return returns[0] if len(returns) == 1 and body and body[-1] is returns[0] else None


def _method(node: ast.ClassDef, name: str) -> Function | None:
    return next((part for part in node.body if isinstance(part, Function) and part.name == name), None)


def _assignments(body: Sequence[ast.stmt]) -> Iterator[tuple[str, Binding]]:
    """Yield the assignments of statements, those of tuples to tuples one by one."""
    for statement in body:
        if isinstance(statement, ast.AnnAssign) and statement.value is not None:
            yield ast.unparse(statement.target), Binding(statement.value, statement, True)
        if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
            continue
        target, value = statement.targets[0], statement.value
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            for name, part in zip(target.elts, value.elts, strict=True):
                yield ast.unparse(name), Binding(part, statement, False)
        elif not isinstance(target, ast.Tuple):
            yield ast.unparse(target), Binding(value, statement, True)


def _once(found: Iterator[tuple[str, Binding]], scope: ast.AST) -> Iterator[tuple[str, Binding]]:
    """Yield the assignments of names that are assigned once in a scope."""
    stores = Counter(
        ast.unparse(node)
        for node in ast.walk(scope)
        if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del)
    )
    return ((name, bound) for name, bound in found if stores[name] == 1)


# Layout of expressions --------------------------------------------------------------------------------------------------------


def laid_out(text: str, indent: str, before: int, behind: int = 0) -> str:
    """Return an expression in the layout of a formatter: on one line if it fits, otherwise with one part per line.

    Args:
        text: The expression, on one line.
        indent: Indentation of its first line.
        before: Number of characters before it in that line.
        behind: Number of characters after its end.
    """
    if before + len(text) + behind <= _MAX_LINE_LENGTH or "\n" in text:
        return text
    node = ast.parse(text, mode="eval").body
    if isinstance(node, ListNode) and node.elts:
        return f"{text[0]}\n{_one_by_one(text, node.elts, indent + INDENT)}{indent}{text[-1]}"
    if not isinstance(node, ast.Call) or not (node.args or node.keywords):
        return text
    deeper = indent + INDENT
    opening = len(ast.get_source_segment(text, node.func) or "")
    head, inner = text[: opening + 1], text[opening + 1 : -1]
    parts: list[ast.expr | ast.keyword] = [*node.args, *node.keywords]
    if len(deeper) + len(inner) <= _MAX_LINE_LENGTH:
        return f"{head}\n{deeper}{inner}\n{indent})"
    if len(parts) == 1:
        return f"{head}\n{deeper}{laid_out(inner, deeper, len(deeper))}\n{indent})"
    return f"{head}\n{_one_by_one(text, parts, deeper)}{indent})"


def _one_by_one(text: str, nodes: Sequence[ast.expr | ast.keyword], indent: str) -> str:
    """Return an expression with each part on its own line, followed by a comma."""
    lines = ""
    for node in nodes:
        part = ast.get_source_segment(text, node) or ""
        lines += f"{indent}{laid_out(part, indent, len(indent), 1) if isinstance(node, ast.expr) else part},\n"
    return lines


def listed(parts: Sequence[str], indent: str, before: int, behind: int = 0, brackets: str = "[]") -> str:
    """Return a list of expressions in the layout of `laid_out`."""
    comma = "," if brackets == "()" and len(parts) == 1 else ""
    line = f"{brackets[0]}{', '.join(parts)}{comma}{brackets[1]}"
    if "\n" not in line:
        return laid_out(line, indent, before, behind)
    inner = "".join(f"{indent}{INDENT}{part},\n" for part in parts)
    return f"{brackets[0]}\n{inner}{indent}{brackets[1]}"


def one_line(text: str) -> str:
    """Return an expression on one line, unless it contains a comment or a string over several lines."""
    if "\n" not in text or "#" in text or '"""' in text:
        return text
    for pattern, new in ((r",\s*\n\s*(?=[\])])", ""), (r",\s*\n\s*", ", "), (r"\s*\n\s*", "")):
        text = re.sub(pattern, new, text)
    return text


def quoted(text: str) -> str:
    """Return a string literal, in double quotes unless single quotes need fewer escapes."""
    inner = repr(f"'\"{text}")[4:-1].replace("\\'", "'")  # quoted singly, and escaped for that
    quote = "'" if text.count('"') > text.count("'") else '"'
    return f"{quote}{inner.replace(quote, chr(92) + quote)}{quote}"


def docstring(text: str, indent: str) -> str:
    """Return a docstring, its first line not indented."""
    safe = text.strip().replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    if safe.endswith('"'):
        safe = f'{safe[:-1]}\\"'
    first, *rest = safe.split("\n")
    if not rest:
        return f'"""{safe}"""'
    lines = "\n".join(f"{indent}{line}".rstrip() for line in rest)
    return f'"""{first}\n{lines}\n{indent}"""'


# Imports ----------------------------------------------------------------------------------------------------------------------


def with_imports(old: Source, new: Source) -> str:
    """Return the text after an edit with the imports from `rlbench_pin.tasks` that it needs, sorted as a formatter does.

    Imports that were unused before the edit stay.
    """
    used, used_before = _used_names(new), _used_names(old)
    missing = {name for name in used - _bound_names(new) - used_before if name in tasks.__all__}
    imports = [node for node in new.tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    statement = next((node for node in imports if isinstance(node, ast.ImportFrom) and node.module == _VOCABULARY), None)
    if statement is None:
        return new.edited([_first_import(new, imports, missing)]) if missing else new.text
    gone = ({alias.asname or alias.name for alias in statement.names} - used) & used_before
    if any(alias.name == "*" for alias in statement.names) or not (missing or gone):
        return new.text
    kept = [alias for alias in statement.names if (alias.asname or alias.name) not in gone]
    names = [f"{alias.name} as {alias.asname}" if alias.asname else alias.name for alias in kept]
    if not names and not missing:
        return new.edited([new.without(statement)])
    return new.edited([(*new.span(statement), _import([*names, *missing]))])


def _import(names: Iterable[str]) -> str:
    """Return an import statement: constants, then classes, then functions."""
    ordered = sorted(names, key=lambda name: (0 if name.isupper() else 1 if name[:1].isupper() else 2, name))
    line = f"from {_VOCABULARY} import {', '.join(ordered)}"
    if len(line) <= _MAX_LINE_LENGTH:
        return line
    return f"from {_VOCABULARY} import (\n{''.join(f'    {name},' + chr(10) for name in ordered)})"


def _first_import(new: Source, imports: Sequence[ast.Import | ast.ImportFrom], names: Iterable[str]) -> Replacement:
    """Return the replacement that inserts the import below all others, or below the docstring."""
    if imports:
        gap = "\n" if isinstance(imports[-1], ast.ImportFrom) and imports[-1].module == "__future__" else ""
        _, end = new.line_span(imports[-1])
        return end, end, f"{gap}{_import(names)}\n"
    if ast.get_docstring(new.tree) is None:
        return 0, 0, f"{_import(names)}\n\n"
    _, end = new.line_span(new.tree.body[0])
    return end, end, f"\n{_import(names)}\n"


def _used_names(source: Source) -> set[str]:
    return {node.id for node in ast.walk(source.tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}


def _bound_names(source: Source) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(alias.asname or alias.name).partition(".")[0] for alias in node.names}
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found.add(node.name)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found


# Names of the scene -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Lookup:
    """A reference to an element by its literal name; `kind` is `body`, `joint`, ..., or `graspable`."""

    kind: str
    name: str
    line: int


def lookups(source: Source) -> tuple[Lookup, ...]:
    """Return the references to elements of the world by string literals."""
    found = []
    for node in ast.walk(source.tree):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute) or not node.args:
            continue
        first, nodes, kind = node.args[0], list[ast.expr](), node.func.attr
        if kind in LOOKUPS and ast.unparse(node.func.value) in ("self.world", "world"):
            nodes = [first]
        if kind == "register_graspable_objects" and isinstance(first, ListNode):
            nodes, kind = first.elts, "graspable"
        found += [Lookup(kind, name, first.lineno) for item in nodes if (name := text_of(item)) is not None]
    return tuple(found)


def mentions(source: Source | None, name: str) -> tuple[str, ...]:
    """Return the lines that name an element of the scene: as a text, by a pattern such as `f"block{i}"`, by its number."""
    if source is None:
        return ()
    lines = {node.lineno for node in _waypoint_numbers(source) if f"waypoint{node.value!r}" == name}
    lines |= {node.lineno for node, text in _string_literals(source.tree) if text == name or text.startswith(f"{name}/")}
    return _shown(source, lines | set(_patterns(source, name)))


def computed_waypoints(source: Source) -> tuple[str, ...]:
    """Return the lines that refer to a waypoint by a computed number or name, which cannot be renamed."""
    found = set()
    for node in ast.walk(source.tree):
        if isinstance(node, ast.JoinedStr) and node.values and (text_of(node.values[0]) or "").startswith("waypoint"):
            found.add(node.lineno)
        if (place := _number_place(node)) is not None and not _is_number(place):
            found.add(place.lineno)
        if isinstance(node, ast.Compare) and any(_is_index(part) for part in (node.left, *node.comparators)):
            found.add(node.lineno)
    return _shown(source, found)


def _is_index(node: ast.expr) -> bool:
    """Return whether an expression is the number of a waypoint, such as `waypoint.index`."""
    return isinstance(node, ast.Attribute) and node.attr == "index"


def renamed_in_python(source: Source, names: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Rename elements of the scene (old name -> new name), all at once.

    Returns:
        The text in which each string literal that is a name, or a name followed by `/...`, has changed, as have the numbers of
        waypoints; and the unchanged lines that name an element in another way.
    """
    found: list[Replacement] = []
    changed: Counter[int] = Counter()
    for node, text in _string_literals(source.tree):
        old = text if text in names else text.partition("/")[0]
        if old in names:
            new = source.part(node).replace(old, names[old], 1)
            if _has_value(new, names[old] + text[len(old) :]):
                found.append((*source.span(node), new))
                changed[node.lineno] += 1
    found += [
        (*source.span(number), new_number[1])
        for number in _waypoint_numbers(source)
        if (new_number := _WAYPOINT.fullmatch(names.get(f"waypoint{number.value!r}", "")))
    ]
    lines = {line for name in names for line in _patterns(source, name)}
    words = re.compile(rf"\b({'|'.join(map(re.escape, names))})\b")
    lines |= {n for n, line in enumerate(source.lines, start=1) if len(words.findall(line)) > changed[n]}
    text = source.edited(found)
    return text, _shown(Source(text), lines)


def _string_literals(tree: ast.AST) -> Iterator[tuple[ast.Constant, str]]:
    """Yield the string literals of a tree with their values, without docstrings and the fixed parts of f-strings."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            skipped.add(id(node.value))
        if isinstance(node, ast.JoinedStr):
            skipped |= {id(part) for part in node.values if isinstance(part, ast.Constant)}
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skipped:
            yield node, node.value


def _patterns(source: Source, name: str) -> Iterator[int]:
    """Yield the lines of f-strings that may produce a name, such as `f"block{i}"`."""
    for node in ast.walk(source.tree):
        if not isinstance(node, ast.JoinedStr):
            continue
        fixed = [text_of(part) for part in node.values]
        if not any(part is not None and re.search(r"[a-z0-9]", part) for part in fixed):
            continue
        pattern = "".join("[a-z0-9_]+" if part is None else re.escape(part) for part in fixed)
        if re.fullmatch(pattern, name) or re.fullmatch(pattern, f"{name}/x") or (fixed[0] or "").startswith(f"{name}/"):
            yield node.lineno


def _waypoint_numbers(source: Source) -> Iterator[ast.Constant]:
    """Yield the literal numbers of waypoints."""
    for node in ast.walk(source.tree):
        place = _number_place(node)
        if isinstance(place, ast.Constant) and _is_number(place):
            yield place


def _number_place(node: ast.AST) -> ast.expr | None:
    """Return the expression that is the number of a waypoint in a call or a subscript."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _BY_NUMBER and node.args:
        return node.args[0]
    if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "self.get_waypoints()":
        return node.slice
    return None


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) is int


def _has_value(written: str, value: str) -> bool:
    try:
        return bool(ast.literal_eval(written) == value)
    except (ValueError, SyntaxError):
        return False


def _shown(source: Source, lines: Iterable[int]) -> tuple[str, ...]:
    return tuple(f"{line}: {source.lines[line - 1].strip()}" for line in sorted(lines))
