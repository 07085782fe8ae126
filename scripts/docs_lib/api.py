"""The reference of the public names: one page for each package, from docstrings."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator, Mapping
from functools import cache
from types import ModuleType

from sphinx.ext.autodoc.mock import mock

from docs_lib.public import OPTIONAL_LIBRARIES, assigned, public_names

FOLDER = "api"
LONGEST_VALUE = 200
"""Constants with more letters are shown without their value."""


def api_pages() -> dict[str, str]:
    """Return file -> text of the index and of one page for each package that has public names."""
    public = public_names()
    homes = names_and_homes(public)
    pages = {f"{FOLDER}/{module}.rst": page(module, names, homes) for module, names in public.items()}
    rows = [(f":doc:`{module}`", first_line(importlib.import_module(module))) for module in sorted(public)]
    text = "Every public name, from the docstrings. Programs import the names from the packages below."
    toctree = "\n".join([".. toctree::", "   :hidden:", "", *(f"   {short(module)} <{module}>" for module in sorted(public))])
    pages[f"{FOLDER}/index.rst"] = f"{title('Python reference')}\n{text}\n\n{toctree}\n\n{list_table(rows)}\n"
    return pages


def short(module: str) -> str:
    """Return the name of a package for the navigation."""
    return module.removeprefix("rlbench_pin.")


def names_and_homes(public: Mapping[str, list[str]]) -> dict[tuple[str, str], str]:
    """Return module and name -> the module whose page documents that object; the shortest one below the package itself."""
    objects = {(module, name): identity(module, name) for module, names in public.items() for name in names}
    homes: dict[object, str] = {}
    for (module, _), item in sorted(
        objects.items(), key=lambda entry: (entry[0][0] == "rlbench_pin", entry[0][0].count("."), entry[0])
    ):
        homes.setdefault(item, module)
    return {key: homes[item] for key, item in objects.items()}


def identity(module: str, name: str) -> object:
    """Return what is the same for a name and for those that it is imported as."""
    item = value_of(module, name)
    if inspect.isclass(item) or inspect.isroutine(item):
        return item.__module__, item.__qualname__
    return name if isinstance(item, ModuleType) else (name, repr(assigned(module, name)))


@cache
def identities() -> set[object]:
    """Return the identities of all public names."""
    return {identity(module, name) for module, names in public_names().items() for name in names}


def value_of(module: str, name: str) -> object:
    """Import a public name."""
    with mock(list(OPTIONAL_LIBRARIES)):
        return getattr(importlib.import_module(module), name)


def page(module: str, names: list[str], homes: Mapping[tuple[str, str], str]) -> str:
    """Return the page of a package."""
    parts = [title(module), f".. automodule:: {module}\n   :no-members:\n"]
    items = [(name, value_of(module, name)) for name in names]
    items = [(name, item) for name, item in items if not isinstance(item, ModuleType)]
    rows = [(f":py:obj:`~{homes[module, name]}.{name}`", summary(module, name, item)) for name, item in items]
    parts.append(list_table(rows))
    parts += [entry(module, name, item) for name, item in items if homes[module, name] == module]
    return "\n".join(parts)


def summary(module: str, name: str, item: object) -> str:
    """Return one sentence about a name."""
    if inspect.isclass(item) or inspect.isroutine(item):
        return first_line(item)
    return first_sentence(assigned(module, name).doc)


def first_line(item: object) -> str:
    """Return the first sentence of a docstring."""
    return first_sentence(" ".join((inspect.getdoc(item) or "").split("\n\n")[0].split()))


def first_sentence(text: str) -> str:
    """Return a text up to the end of its first sentence."""
    return text.split(". ")[0].removesuffix(".") + "." if text else ""


def entry(module: str, name: str, item: object) -> str:
    """Return the directive that documents a name."""
    full = f"{module}.{name}"
    if inspect.isclass(item):
        inherited = f"   :inherited-members: {', '.join(apart)}\n" if (apart := public_bases(item)) else ""
        return f".. autoclass:: {full}\n   :members:\n   :show-inheritance:\n{inherited}"
    if inspect.isroutine(item):
        return f".. autofunction:: {full}\n"
    return "\n".join(constant(module, name, item))


def public_bases(kind: type) -> list[str]:
    """Return the bases whose members are not repeated, where a class has bases of ours that are not public; else nothing."""
    hidden = [
        b
        for b in kind.__mro__[1:]
        if b.__module__.startswith("rlbench_pin") and (b.__module__, b.__qualname__) not in identities()
    ]
    return [b.__name__ for b in kind.__mro__[1:] if b not in hidden] if hidden else []


def constant(module: str, name: str, item: object) -> Iterator[str]:
    """Yield the lines of a constant, or of an alias of a type."""
    found = assigned(module, name)
    if is_type(name):
        yield f".. py:type:: {name}"
        yield f"   :canonical: {found.value}"
    else:
        yield f".. py:data:: {name}"
        yield f"   :type: {found.annotation or type(item).__name__}"
        value = repr(item) if isinstance(item, tuple | str | int | float) else found.value
        if len(value) <= LONGEST_VALUE:
            yield f"   :value: {value}"
    yield f"\n   {found.doc}\n"


def is_type(name: str) -> bool:
    """Return whether a constant is an alias of a type: it is written as classes are."""
    return name[0].isupper() and not name.isupper()


def title(text: str) -> str:
    """Return the heading of a page."""
    return f"{text}\n{'=' * len(text)}\n"


def list_table(rows: list[tuple[str, str]]) -> str:
    """Return a table of two columns without a head."""
    lines = [".. list-table::", "   :widths: 35 65", "   :class: names", ""]
    for first, second in rows:
        lines += [f"   * - {first}", f"     - {second}"]
    return "\n".join(lines) + "\n"
