"""All things of the scene with their names, children below their parents."""

from __future__ import annotations

from collections.abc import Iterator

from rlbench_pin.builder.view.panels.waypoints import SHADES
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Fold, Item, Note
from rlbench_pin.builder.view.widgets.items import Shade
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec

_MARKS = {"BodySpec": "■", "FrameSpec": "✛", "RegionSpec": "▭", "SensorSpec": "◎", "WaypointSpec": "◆"}


def tree_items(session: Session) -> list[Item]:
    """Return a button for each thing, indented below its parent."""
    spec = session.spec
    items: list[Item] = [_button(session, ROOT, "⌂ root", 0)]
    items += [
        _button(session, thing.name, f"{_MARKS[type(thing).__name__]} {thing.name}", depth) for thing, depth in branches(spec)
    ]
    if not spec.posed():
        items.append(Note("Nothing is here yet: see *Add*."))
    return items


def branches(spec: SceneSpec) -> Iterator[tuple[PosedSpec, int]]:
    """Yield all things, each behind its parent, with how many parents it has; those whose parents go in circles come last."""
    children: dict[str, list[PosedSpec]] = {}
    for thing in spec.posed():
        children.setdefault(thing.parent.partition("/")[0], []).append(thing)
    seen: set[str] = set()
    yield from _below(ROOT, children, 1, seen)
    yield from _below(WORLD, children, 0, seen)
    yield from ((thing, 0) for thing in spec.posed() if thing.name not in seen)


def _below(parent: str, children: dict[str, list[PosedSpec]], depth: int, seen: set[str]) -> Iterator[tuple[PosedSpec, int]]:
    for thing in children.get(parent, ()):
        if thing.name not in seen:
            seen.add(thing.name)
            yield thing, depth
            yield from _below(thing.name, children, depth + 1, seen)


def _button(session: Session, name: str, label: str, depth: int) -> Button:
    verdict = session.sight.verdicts.get(name)
    shade: Shade = "gray" if verdict is None else SHADES[verdict.standing]
    if name == session.selected:
        shade = "blue"
    indent = "\u2003" * depth
    return Button(
        f"{indent}{label}", lambda: session.select(name), shade, hint=verdict.cause if verdict else "", key=f"{depth} {name}"
    )


def header_items(session: Session) -> list[Item]:
    """Return undo, redo and save, with what they are about."""
    document = session.document
    undo, redo = document.undoable, document.redoable
    title = f"**{document.name}**{' ·  not saved' if document.unsaved else ''}"
    items: list[Item] = [
        Note(title),
        Button(f"Undo: {undo}" if undo else "Undo", lambda: session.do(lambda d: d.undo()), disabled=not undo, key="undo"),
        Button(f"Redo: {redo}" if redo else "Redo", lambda: session.do(lambda d: d.redo()), disabled=not redo, key="redo"),
        Button("Save", session.save, "blue" if document.unsaved else "gray", key="save"),
    ]
    if session.typed:
        items.append(Note(f"Typed in {' and '.join(sorted(session.typed))}, not applied: see *Files*."))
    if problems := document.problems:
        lines = [
            f"- `{document.name}.{'toml' if p.file == 'scene' else 'py'}` line {p.line or '-'}: {p.message}" for p in problems
        ]
        items.append(Fold(f"Problems ({len(problems)})", [Note("\n".join(lines))]))
    return items
