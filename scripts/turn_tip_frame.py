"""Rotate tip poses in scene files by 180 degrees about the z axis of the tip, like the tip frame on 2026-11-22.

Older scene files have tip poses in the old frame. The script rewrites waypoints and their children, so that the
gripper moves to the same poses; it does not change comments and other entries. Run it once per file.

Usage: python scripts/turn_tip_frame.py [--frames PREFIX ...] FILE.toml ...
`--frames grasp_ drop_` also rotates the frames with these prefixes, which are target poses of waypoints.
"""

from __future__ import annotations

import argparse
import re
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

HALF = 3.1415927
NUMBERS = re.compile(r"\[[^\[\]]*\]")
TABLE = re.compile(r"(?m)^(?=\[)")


def _text(numbers: Sequence[float], like: Sequence[str]) -> str:
    """Write numbers as they were written before, but for signs; new ones with seven digits."""
    words = []
    for i, number in enumerate(numbers):
        old = like[i].strip() if i < len(like) else ""
        if old and abs(float(old) - number) < 1e-12:
            words.append(old)
        elif old and abs(float(old) + number) < 1e-12:
            words.append(old.removeprefix("-") if old.startswith("-") else f"-{old}")
        else:
            words.append(f"{round(number, 7) + 0.0}")
    return f"[{', '.join(words)}]"


def _wrapped(angle: float) -> float:
    angle = float(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)
    return HALF if abs(abs(angle) - np.pi) < 1e-6 else (0.0 if abs(angle) < 1e-6 else angle)


def _turn(text: str, kind: str, before: bool, after: bool) -> str:
    """Return one `[...]` turned on the side of the parent (`before`), of the hand (`after`), or of both."""
    like = text.strip("[]").split(",")
    v = [float(word) for word in like]
    if kind == "rpy":
        roll, pitch, yaw = v
        sign = -1.0 if after else 1.0
        return _text([_wrapped(sign * roll), sign * pitch, _wrapped(yaw + (HALF if before != after else 0.0))], like)
    if before:
        v[:2] = [-v[0], -v[1]]
    if kind == "axis":
        return _text(v, like)
    if len(v) == 4:
        v[3] = _wrapped(v[3] + (HALF if before != after else 0.0))
    elif len(v) == 7:
        x, y, z, w = v[3:]
        if before:
            x, y, z, w = y, -x, -w, z
        if after:
            x, y, z, w = y, -x, w, -z
        v[3:] = [-c for c in (x, y, z, w)] if (w, z) < (0.0, 0.0) else [x, y, z, w]
    return _text(v, like)


def _rewrite(block: str, turned: set[str]) -> str:
    entry = next(iter(tomllib.loads(block).values()))[0]
    before, after = entry.get("parent") in turned, entry["name"] in turned
    full_points = any(len(point) > 3 for point in entry.get("points", []))
    lines, inside = [], ""
    for line in block.split("\n"):
        key = line.split("=")[0].strip()
        inside = "points" if key == "points" else ("" if line.startswith("]") else inside)
        if key in ("pose", "rpy"):
            line = NUMBERS.sub(lambda m, k=key: _turn(m[0], k, before, after), line, count=1)
        elif key == "arc" and after:
            line = NUMBERS.sub(lambda m: _turn(m[0], "axis", True, True), line, count=1)
        elif inside and key != "points":
            line = NUMBERS.sub(lambda m: _turn(m[0], "pose", after, full_points or after), line)
        lines.append(line)
    lines = [_aligned(new, old) for new, old in zip(lines, block.split("\n"), strict=True)]
    if before != after and "rpy" not in entry and len(entry.get("pose", [0.0] * 3)) == 3:
        lines = _with_yaw(lines)
    return "\n".join(lines)


def _aligned(line: str, old: str) -> str:
    """Put a comment where it began before."""
    if "#" not in line or "#" not in old:
        return line
    code, comment = line.split("#", 1)
    return f"{code.rstrip():<{old.index('#')}}#{comment}" if old.index("#") else line


def _with_yaw(lines: list[str]) -> list[str]:
    """Add half a turn to a pose of three numbers, or a pose where there is none."""
    at = next((i for i, line in enumerate(lines) if line.split("=")[0].strip() == "pose"), None)
    if at is not None:
        return [*lines[:at], lines[at].replace("]", f", {HALF}]", 1), *lines[at + 1 :]]
    at = max(i for i, line in enumerate(lines) if line.split("=")[0].strip() in ("name", "parent"))
    return [*lines[: at + 1], f"pose = [0.0, 0.0, 0.0, {HALF}]", *lines[at + 1 :]]


def turn_file(file: Path, prefixes: Sequence[str] = ()) -> None:
    """Rewrite one scene file."""
    text = file.read_text(encoding="utf-8")
    scene = tomllib.loads(text)
    waypoints = {w["name"]: w for w in scene.get("waypoint", [])}
    turned = {f["name"] for f in scene.get("frame", []) if prefixes and f["name"].startswith(tuple(prefixes))}
    turned |= {name for name, w in waypoints.items() if "arc" not in w and not any(len(p) > 3 for p in w.get("points", []))}
    turned |= {name for name, w in waypoints.items() if "arc" in w and w.get("parent") in turned}
    affected = {f["name"] for f in scene.get("frame", []) + scene.get("sensor", []) if f.get("parent") in turned}
    names = turned | affected | set(waypoints)
    blocks = TABLE.split(text)
    for i, block in enumerate(blocks):
        found = re.search(r'(?m)^name = "([^"]+)"', block)
        if found and found[1] in names and block.startswith(("[[waypoint]]", "[[frame]]", "[[sensor]]")):
            blocks[i] = _rewrite(block, turned)
    file.write_text("".join(blocks), encoding="utf-8")


def main(arguments: Sequence[str]) -> int:
    """Rewrite the files of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--frames", nargs="*", default=[], help="prefixes of frames that are poses of the gripper")
    options = parser.parse_args(arguments)
    for file in options.files:
        turn_file(file, options.frames)
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
