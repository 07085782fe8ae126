"""Settings of Sphinx; `make docs` builds the site from `out/docs_src`, which `scripts/build_docs.py` writes."""

from __future__ import annotations

import importlib
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst.states import Inliner
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.ext.autodoc.mock import mock

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from docs_lib.public import OPTIONAL_LIBRARIES, TYPE_ALIASES  # noqa: E402

from rlbench_pin import __version__  # noqa: E402

project = "rlbench-pin"
author = "rlbench_pin developers"
version = release = __version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_markdown_builder",
]
nitpicky = True
nitpick_ignore_regex = [
    (r"py:.*", r"(?!rlbench_pin\b).*"),  # classes of other libraries: the site links to no other site
    (r"py:.*", r"rlbench_pin\.(.*\.)?_\w+(\.\w+)*"),  # private names in annotations
]
show_warning_types = True

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 6
default_role = "name"

autodoc_mock_imports = list(OPTIONAL_LIBRARIES)
autodoc_type_aliases = TYPE_ALIASES
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
autodoc_inherit_docstrings = False
napoleon_numpy_docstring = False
napoleon_use_ivar = True
python_use_unqualified_type_names = True
maximum_signature_line_length = 100
toc_object_entries = False  # thousands of names in the navigation of every page, which takes minutes

html_theme = "furo"
html_title = f"rlbench-pin {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("task_list.js", {"defer": "defer"})]
html_copy_source = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}
markdown_anchor_signatures = False


def name_role(
    role: str, raw: str, text: str, line: int, inliner: Inliner, options: Any = None, content: Any = None
) -> tuple[list[nodes.Node], list[nodes.system_message]]:
    """Show text in single backticks as code, with a link where it is a public name; docstrings use them as Markdown does."""
    text = nodes.unescape(text, restore_backslashes=True)
    code = nodes.literal(text, text, classes=["xref", "py"])
    target = text.removesuffix("()")
    if not re.fullmatch(r"[A-Za-z_]\w*(\.\w+)*", target):
        return [nodes.literal(text, text)], []
    env = inliner.document.settings.env
    link = pending_xref(
        "", code, refdomain="py", reftype="obj", reftarget=target, refexplicit=False, refwarn=False, refdoc=env.docname
    )
    link.update_basic_atts({"py:module": env.ref_context.get("py:module"), "py:class": env.ref_context.get("py:class")})
    link["py:module"], link["py:class"] = env.ref_context.get("py:module"), env.ref_context.get("py:class")
    return [link], []


def drop_private_bases(app: Sphinx, name: str, item: object, options: Any, bases: list[Any]) -> None:
    """Show public bases only."""
    bases[:] = [base for base in bases if not getattr(base, "__name__", "").startswith("_")] or [object]


def markdown_text(app: Sphinx, what: str, name: str, item: object, options: Any, lines: list[str]) -> None:
    """Keep bars, which are no substitutions in our docstrings, and colons in texts of attributes, which end no type."""
    lines[:] = [line.replace("|", "\\|") for line in lines]
    if what == "attribute" and lines:
        lines[0] = f": {lines[0]}"


def without_link(app: Sphinx, env: BuildEnvironment, node: pending_xref, text: nodes.Node) -> nodes.Node | None:
    """Show names of ours that exist but are not public without a link; all others are dead links."""
    parts = node.get("reftarget", "").split(".")
    for count in range(len(parts), 1, -1):
        with suppress(ImportError), mock(autodoc_mock_imports):
            value = importlib.import_module(".".join(parts[:count]))
            for name in parts[count:]:
                value = getattr(value, name, None)
            return text if value is not None else None
    return None


def plain_separators(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """Write the `*` of signatures as text in Markdown, whose builder knows no abbreviations."""
    if app.builder.name == "markdown":
        for node in list(doctree.findall(nodes.abbreviation)):
            node.replace_self(nodes.Text(node.astext()))


def setup(app: Sphinx) -> None:
    """Register the role of single backticks and what autodoc leaves out."""
    app.add_role("name", name_role)
    app.connect("autodoc-process-bases", drop_private_bases)
    app.connect("autodoc-process-docstring", markdown_text, priority=400)  # before napoleon
    app.connect("missing-reference", without_link)
    app.connect("doctree-resolved", plain_separators)
