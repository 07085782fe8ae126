"""What a person does with the mouse reaches the file, and can be taken back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rlbench_pin.builder.document import TaskDocument
from tests.builder.browser.conftest import Sit
from tests.builder.browser.page import until


def test_a_dragged_body_moves_in_the_file_and_back(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """Clicked in the scene, dragged along an arrow of the gizmo, undone to the same bytes."""
    document = copied("pick_and_lift")
    desk = sit(document)
    page, session = desk.page, desk.session
    desk.settle()
    before = document.text
    page.quiet()
    page.screenshot("opened")
    seen = session.places.elements["distractor0"][:3] + (0.0, 0.0, 0.015)
    page.click_until(seen, lambda: session.selected == "distractor0", "the block is selected")
    page.shows("Duplicate")
    start = session.places.elements["distractor0"][:3].copy()
    page.drag(start + (0.0, 0.125, 0.0), start + (0.0, 0.225, 0.0))
    until(lambda: document.undoable and not desk.window.view.is_dragging, "an edit, and the end of the drag")
    desk.settle()
    moved = session.places.elements["distractor0"][:3]
    assert np.allclose(moved - start, (0.0, 0.1, 0.0), atol=0.021)
    assert abs(moved[0] - start[0]) < 1e-9
    assert document.scene_text != before.scene
    page.screenshot("dragged")
    page.press(f"Undo: {document.undoable}")
    until(lambda: document.text == before, "the same bytes")
    assert not document.unsaved


def test_the_tree_selects_and_numbers_move(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """A number that is typed stands in the file; renaming changes it everywhere at once."""
    document = copied("pick_and_lift")
    desk = sit(document)
    desk.page.quiet()
    desk.page.press("■ block")
    desk.page.type("x y z [m]", "0.07")
    until(lambda: "pose = [0.07, 0.0, 0.0225]" in document.scene_text, "the number in the file")
    desk.page.type("Name", "brick")
    desk.page.press("Rename")
    until(lambda: 'parent = "brick"' in document.scene_text, "the new name in the scene")
    assert 'self.world.body("brick")' in document.python_text
    assert '"block"' not in document.scene_text
    desk.page.press("Save")
    until(lambda: not document.unsaved, "saved")
    assert (document.folder / "pick_and_lift.toml").read_text() == document.scene_text


def test_every_tab_has_undo_redo_and_save(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """Whatever is open on the left and on the right, an edit is undone, repeated and saved there."""
    document = copied("pick_and_lift")
    desk = sit(document)
    page, before = desk.page, document.text
    page.quiet()
    desk.session.post(lambda: desk.session.do(lambda d: d.set("block", "fixed", True)))
    desk.settle()
    name = document.undoable
    for tab in ("Scene", "Add", "Selected", "Behaviour", "Files", "Try", "Validate"):
        page.tab(tab)
        page.press(f"Undo: {name}")
        until(lambda: document.text == before, "undone")
        page.press(f"Redo: {name}")
        until(lambda: document.text != before, "repeated")
    page.press("Save")
    until(lambda: not document.unsaved, "saved")


_MARK_PLACES = """
return Object.fromEntries([...document.querySelectorAll('button')].map(button => {
  const text = document.createTreeWalker(button, NodeFilter.SHOW_TEXT).nextNode();
  if (!text) return ['', 0];
  const label = text.textContent.trim(), range = document.createRange();
  range.setStart(text, text.textContent.indexOf(label)); range.setEnd(text, text.textContent.indexOf(label) + 1);
  return [label, range.getBoundingClientRect().left];
}));
"""


def test_the_tree_is_indented(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """Elements of one parent begin at one place, to the right of their parent."""
    desk = sit(copied("pick_and_lift"))
    desk.settle()

    def places() -> dict[str, float]:
        return dict(desk.page.browser.execute_script(_MARK_PLACES))

    until(lambda: "◎ goal" in places(), "the tree")
    at = places()
    columns = [("⌂ root",), ("■ block", "■ marker", "▭ boundary"), ("◆ waypoint1", "◎ goal"), ("◆ waypoint0", "◆ waypoint2")]
    lefts = [[at[name] for name in names] for names in columns]
    for row in lefts:
        assert np.ptp(row) < 0.5
    assert np.diff([row[0] for row in lefts]).min() > 8.0


def test_the_catalogue_is_a_grid_with_sizes(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """Two objects beside one another, each with its image and size above its button."""
    desk = sit(copied("pick_and_lift"))
    page = desk.page
    page.tab("Add")
    page.type("Search", "cube_")
    page.shows("cube_45, 4.5 x 4.5 x 4.5 cm")
    first, second = ([b for b in page.browser.find_elements("css selector", "button") if b.text.startswith("Add cube_")])[:2]
    assert first.rect["y"] == second.rect["y"] and first.rect["x"] + first.rect["width"] <= second.rect["x"]
    image = page.browser.find_element("css selector", "img[alt*='cube_'], img[src^='blob:'], img[src^='data:image/jpeg']")
    assert image.rect["y"] < first.rect["y"]
    page.screenshot("grid")
