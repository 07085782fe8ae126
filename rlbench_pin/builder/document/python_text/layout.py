"""Expressions laid out as a formatter does: on one line where they fit, otherwise part by part."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence

LONGEST_LINE = 130
INDENT = "    "


def laid_out(text: str, indent: str, before: int, behind: int = 0) -> str:
    """Return an expression on as few lines as fit.

    Args:
        text: The expression, on one line.
        indent: Indentation of the line in which it begins.
        before: How many letters stand before it in that line.
        behind: How many letters stand behind its end.
    """
    if before + len(text) + behind <= LONGEST_LINE or "\n" in text:
        return text
    node = ast.parse(text, mode="eval").body
    if isinstance(node, ast.List | ast.Tuple) and node.elts:
        head, tail = text[0], text[-1]
        return f"{head}\n{_each(text, node.elts, indent + INDENT)}{indent}{tail}"
    if isinstance(node, ast.Call) and (node.args or node.keywords):
        return _call(text, node, indent)
    return text


def one_line(text: str) -> str:
    """Return an expression on one line, where no comment keeps it on several."""
    if "\n" not in text or "#" in text or '"""' in text:
        return text
    for pattern, new in ((r",\s*\n\s*(?=[\])])", ""), (r",\s*\n\s*", ", "), (r"\s*\n\s*", "")):
        text = re.sub(pattern, new, text)
    return text


def listed(parts: Sequence[str], indent: str, before: int, behind: int = 0, brackets: str = "[]") -> str:
    """Return a list of expressions, laid out likewise."""
    comma = "," if brackets == "()" and len(parts) == 1 else ""
    line = f"{brackets[0]}{', '.join(parts)}{comma}{brackets[1]}"
    if "\n" not in line:
        return laid_out(line, indent, before, behind)
    inner = "".join(f"{indent}{INDENT}{part},\n" for part in parts)
    return f"{brackets[0]}\n{inner}{indent}{brackets[1]}"


def _call(text: str, node: ast.Call, indent: str) -> str:
    deeper = indent + INDENT
    opening = len(ast.get_source_segment(text, node.func) or "")
    head, inner = text[: opening + 1], text[opening + 1 : -1]
    parts: list[ast.expr | ast.keyword] = [*node.args, *node.keywords]
    if len(deeper) + len(inner) <= LONGEST_LINE:
        return f"{head}\n{deeper}{inner}\n{indent})"
    if len(parts) == 1:
        return f"{head}\n{deeper}{laid_out(inner, deeper, len(deeper))}\n{indent})"
    return f"{head}\n{_each(text, parts, deeper)}{indent})"


def _each(text: str, nodes: Sequence[ast.expr | ast.keyword], indent: str) -> str:
    """Return each part on its own line, with a comma behind it."""
    lines = ""
    for node in nodes:
        part = ast.get_source_segment(text, node) or ""
        lines += f"{indent}{laid_out(part, indent, len(indent), 1) if isinstance(node, ast.expr) else part},\n"
    return lines
