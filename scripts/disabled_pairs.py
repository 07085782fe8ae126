"""Write the SRDF of an arm next to its URDF: the pairs of links whose collisions are ignored. The output is deterministic.

Usage: python scripts/disabled_pairs.py ARM_URDF
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from assets_lib.files import write_text

from rlbench_pin.robot.self_collisions import srdf_text


def main() -> None:
    """Read the command line and write the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("urdf", type=Path, metavar="ARM_URDF")
    urdf = parser.parse_args().urdf
    write_text(urdf.with_suffix(".srdf"), srdf_text(urdf))
    print(f"Wrote {urdf.with_suffix('.srdf')}.")


if __name__ == "__main__":
    main()
