"""Write the tables of docs/baselines.md and docs/results/baselines.md from docs/results/baselines/, which `make baselines` plays.

With `--check` nothing is written; it only reports whether the pages are out of date.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from baselines_lib.tables import pages, write_tables


def main() -> int:
    """Update, or check."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when a page is out of date")
    arguments = parser.parse_args()
    stale = [path.name for path, text in pages().items() if not path.is_file() or path.read_text(encoding="utf-8") != text]
    if not arguments.check:
        write_tables()
    print(f"{'out of date' if arguments.check else 'updated'}: {', '.join(stale) or 'nothing'}")
    return int(arguments.check and bool(stale))


if __name__ == "__main__":
    sys.exit(main())
