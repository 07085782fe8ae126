"""Build the documentation site: `out/docs_src` from `docs/` and from what is generated, then HTML and Markdown in `out/docs`.

Usage: python scripts/build_docs.py [--out out]    or `make docs`; a warning of Sphinx is an error
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from docs_lib.api import api_pages
from docs_lib.arms import arm_page
from docs_lib.error_table import error_page
from docs_lib.pages import copied_pages, write
from docs_lib.tasks import task_pages
from sphinx.cmd.build import build_main

ROOT = Path(__file__).resolve().parents[1]


def main() -> int:
    """Write the sources, then the site."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "out", help="folder of `docs_src` and `docs`")
    parser.add_argument("--jobs", default="auto", help="processes of Sphinx")
    options = parser.parse_args()
    source, site = options.out / "docs_src", options.out / "docs"
    pages = {**copied_pages(source), **api_pages(), **error_page(), **arm_page(source), **task_pages(source)}
    write(source, pages)
    common = ["-W", "--keep-going", "-q", "-j", options.jobs, "-c", str(ROOT / "docs"), "-d", str(options.out / "doctrees"), str(source)]
    return build_main(["-b", "html", *common, str(site)])


if __name__ == "__main__":
    sys.exit(main())
