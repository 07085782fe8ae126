"""Several tabs see and do the same; what a page shows survives its reload; files come in through its button."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import trimesh
from selenium.webdriver.common.by import By

from rlbench_pin.builder.document import TaskDocument
from tests.builder.browser.conftest import Desk, Sit
from tests.builder.browser.page import until
from tests.builder.custom_assets.files import cabinet

CLICKS = 4
_CLICK = """
const press = () => [...document.querySelectorAll('button')].find(e => e.innerText.trim() === 'Duplicate').click();
for (let k = 0; k < arguments[0]; k++) setTimeout(press, 1500 + 150 * k);
"""


def _tree(desk: Desk) -> list[str]:
    """Return the names that stand in the tree of the tab that is looked at."""
    buttons = desk.page.browser.find_elements(By.TAG_NAME, "button")
    marked = [button.text.strip() for button in buttons]
    return [text for text in marked if text[:1] in "■✛▭◎◆" and text]


def test_two_tabs_see_the_same(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """An edit of one is seen and undone in the other; edits of both at once all count; a reload shows what was there."""
    document = copied("pick_and_lift")
    desk, before = sit(document), document.text
    page, browser = desk.page, desk.page.browser
    desk.settle()
    first = browser.current_window_handle
    second = page.new_tab(desk.address)
    page.press("■ block")
    page.shows("Duplicate")
    page.type("x y z [m]", "0.07")
    until(lambda: "pose = [0.07, 0.0, 0.0225]" in document.scene_text, "the number in the file")
    browser.switch_to.window(first)
    until(lambda: page.field("x y z [m]").get_attribute("value") == "0.07", "the number in the other tab")
    page.press(f"Undo: {document.undoable}")
    until(lambda: document.text == before, "undone")
    browser.switch_to.window(second)
    until(lambda: page.field("x y z [m]").get_attribute("value") == "0", "undone in the tab that made it")
    for tab in (first, second):
        browser.switch_to.window(tab)
        browser.execute_script(_CLICK, CLICKS)
    until(lambda: len(document.spec.body) == 4 + 2 * CLICKS, "all copies")  # type: ignore[union-attr]
    desk.settle()
    names = {body.name for body in document.spec.body}  # type: ignore[union-attr]
    trees = []
    for tab in (first, second):
        browser.switch_to.window(tab)
        until(lambda: len(_tree(desk)) == 10 + 2 * CLICKS, "the whole tree")
        trees.append(_tree(desk))
    assert trees[0] == trees[1]
    assert {text.removeprefix("■ ") for text in trees[0]} >= names
    selected = desk.session.selected
    browser.refresh()
    until(lambda: _tree(desk) == trees[0], "the same tree after a reload")
    until(lambda: page.field("Name").get_attribute("value") == selected, "the same element is selected")
    assert page.errors() == []


def test_a_custom_mesh(sit: Sit, copied: Callable[[str], TaskDocument], tmp_path: Path) -> None:
    """Given to the button, it is a body beside the task, and in the scene; what is no mesh is refused with the reason."""
    document = copied("pick_and_lift")
    desk = sit(document)
    page = desk.page
    page.quiet()
    mesh, text = tmp_path / "up" / "wedge.obj", tmp_path / "up" / "letter.obj"
    mesh.parent.mkdir()
    trimesh.creation.capsule(height=0.05, radius=0.02).export(mesh)
    text.write_text("Dear Sir or Madam")
    page.tab("Add")
    page.fold("Custom mesh")
    until(lambda: page.browser.find_elements(By.CSS_SELECTOR, "input[type='file']"), "the button")
    page.upload(text)
    page.shows("Not done")
    page.quiet()
    page.upload(mesh)
    until(lambda: "./wedge/wedge.urdf" in document.scene_text, "the body")
    assert (document.folder / "wedge" / "wedge.urdf").is_file()
    desk.settle()
    assert desk.session.status.opened is not None
    assert desk.session.status.opened.problems == ()
    until(lambda: page.browser.execute_script("return '/bodies/wedge' in window.__viserSceneTree.getState()"), "it is drawn")
    page.screenshot("custom_mesh")
    assert page.errors() == []


def test_a_custom_urdf(sit: Sit, copied: Callable[[str], TaskDocument], tmp_path: Path) -> None:
    """An archive with a URDF file is a body whose joints have sliders; a file that is too large is refused with its size."""
    document = copied("pick_and_lift")
    desk = sit(document)
    page = desk.page
    page.quiet()
    huge, model = tmp_path / "statue.urdf", tmp_path / "cabinet.zip"
    model.write_bytes(cabinet())
    with huge.open("wb") as file:
        file.truncate(100 * 2**20)
    page.tab("Add")
    page.fold("Custom URDF")
    until(lambda: page.browser.find_elements(By.CSS_SELECTOR, "input[type='file']"), "the button")
    page.upload(huge)
    page.shows("'statue.urdf' is refused: it is empty or larger than 64 MB")
    page.quiet()
    page.upload(model)
    until(lambda: "./cabinet/" in document.scene_text, "the cabinet")
    page.tab("Selected")
    page.shows("hinge")
    page.type("Starts at [rad]", "0.7", 2)
    until(lambda: [joint.position for joint in document.spec.joint] == [0.7], "the door stands open")
    desk.settle()
    page.screenshot("custom_model")
    assert page.errors() == []
