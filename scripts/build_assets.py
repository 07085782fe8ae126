"""Rebuild all files in `rlbench_pin/assets`: robots, room, objects, catalogue. The output is byte-identical for the same input.

Usage: python scripts/build_assets.py [--out FOLDER] [--only objects|panda|ur5e|...] [--family NAME ...] [--airo FOLDER]
`--family` rebuilds only the named families and does not change the catalogue; run without it before a commit.
Objects need only numpy and scipy; arms also need Pinocchio and example-robot-data, and take some minutes each. The UR5e
is built from the wheel of airo-models 0.0.12, installed or in the folder of `--airo`; without it the arm is not changed.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from assets_lib import objects
from assets_lib.catalogue import write_catalogue, write_licences
from assets_lib.textures import ROOM, write_patterns, write_room_textures, write_texture_set
from assets_lib.urdf import Model, write_model

ASSETS = Path(__file__).parents[1] / "rlbench_pin" / "assets"
ARM_NAMES = ("panda", "ur5e", "xarm7", "jaco", "iiwa")


def models_of(families: Iterable[str]) -> tuple[Model, ...]:
    """Return the objects of some families, each a module of `assets_lib/objects`."""
    return tuple(model for family in families for model in importlib.import_module(f"assets_lib.objects.{family}").models())


def build_objects(out: Path) -> None:
    """Write the objects, the room, the catalogue and the licences below `out`."""
    models = models_of(sorted(module.name for module in pkgutil.iter_modules(objects.__path__)))
    for model in models:
        write_model(model, out)
    write_room_textures(out)
    write_texture_set(out)
    write_patterns(out)
    write_catalogue(models, out)
    write_licences(models, out)


def build_arm(name: str, out: Path, airo: Path | None) -> None:
    """Write an arm below `out`; say so when the files that it is made from are missing."""
    from assets_lib.arms import SourceMissing

    module = importlib.import_module(f"assets_lib.{name}")
    try:
        if name == "ur5e":
            module.build_ur5e(out, airo)
        else:
            getattr(module, f"build_{name}")(out)
    except SourceMissing as error:
        print(f"{name} is not changed. {error}", file=sys.stderr)


def replace_folder(new: Path, old: Path) -> None:
    """Make the folder `old` equal to `new`; files that are already equal are not touched."""
    wanted = {path.relative_to(new) for path in new.rglob("*") if path.is_file()}
    for path in sorted(old.rglob("*")) if old.is_dir() else ():
        if path.is_file() and path.relative_to(old) not in wanted:
            path.unlink()
    for name in sorted(wanted):
        data, target = (new / name).read_bytes(), old / name
        if not target.is_file() or target.read_bytes() != data:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)


def build(out: Path, only: str | None = None, airo: Path | None = None) -> None:
    """Build in a temporary folder, then replace the folders and the two texts of `out`."""
    with tempfile.TemporaryDirectory() as name:
        temporary = Path(name)
        if only in (None, "objects"):
            build_objects(temporary)
        for name in ARM_NAMES:
            if only in (None, name):
                build_arm(name, temporary, airo)
        out.mkdir(parents=True, exist_ok=True)
        for made in sorted(temporary.iterdir()):
            if made.name == "robots":  # an arm whose files no script makes stays as it is
                for robot in sorted(made.iterdir()):
                    replace_folder(robot, out / made.name / robot.name)
            elif made.is_dir():
                replace_folder(made, out / made.name)
            else:
                (out / made.name).write_bytes(made.read_bytes())


def build_families(out: Path, names: Iterable[str]) -> None:
    """Rebuild the objects of some families, each folder replaced when it is whole."""
    with tempfile.TemporaryDirectory() as name:
        temporary = Path(name)
        for model in models_of(names):
            write_model(model, temporary)
            if model.folder == ROOM:
                write_room_textures(temporary)
            replace_folder(temporary / model.folder, out / model.folder)


def main() -> None:
    """Read the command line and build."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ASSETS)
    parser.add_argument("--only", choices=("objects", *ARM_NAMES), default=None)
    parser.add_argument("--family", nargs="+", default=(), metavar="NAME")
    parser.add_argument("--airo", type=Path, default=None, metavar="FOLDER")
    options = parser.parse_args()
    if options.family:
        build_families(options.out, options.family)
    else:
        build(options.out, options.only, options.airo)


if __name__ == "__main__":
    main()
