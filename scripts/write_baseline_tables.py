"""Write the tables of docs/baselines.md and docs/results/baselines.md from docs/results/baselines/, which `make baselines` plays.

With `--check` nothing is written; it only reports whether the pages are out of date.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from baselines_lib.tables import pages
from update_readme import checks_only, write_pages

if __name__ == "__main__":
    sys.exit(write_pages(checks_only(__doc__), pages()))
