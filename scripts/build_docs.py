"""Build the documentation site in `out/docs`: its sources, from `docs/` and generated pages, then HTML and Markdown.

Usage: python scripts/build_docs.py [--out out] [--jobs auto]    or `make docs`; a warning of Sphinx is an error
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from docs_lib.api import api_pages
from docs_lib.arms import arm_page
from docs_lib.error_table import error_page
from docs_lib.llms import write_markdown
from docs_lib.pages import copied_pages, write
from docs_lib.tasks import task_pages
from sphinx.cmd.build import build_main

ROOT = Path(__file__).resolve().parents[1]


def main() -> int:
    """Write the sources, then the site."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out", help="folder of the sources, `docs_src`, and of the site, `docs`"
    )
    parser.add_argument("--jobs", default="auto", help="number of Sphinx processes")
    options = parser.parse_args()
    out = options.out.resolve()
    source, site, rendered = out / "docs_src", out / "docs", out / "docs_markdown"
    reference = api_pages()
    pages = {**copied_pages(source), **reference, **error_page(), **arm_page(source), **task_pages(source)}
    write(source, pages)
    common = ["-c", str(ROOT / "docs"), "-d", str(out / "doctrees"), str(source)]
    status = build_main(["-b", "html", "-j", options.jobs, "-W", "--keep-going", "-q", *common, str(site)])
    if status == 0:  # the same pages as Markdown: all that Sphinx has to say about them was said
        status = build_main(["-b", "markdown", "-Q", *common, str(rendered), *(str(source / name) for name in reference)])
    if status == 0:
        write_markdown(pages, rendered, site)
        print(f"{len(pages)} pages in {site}")
    return status


if __name__ == "__main__":
    sys.exit(main())
