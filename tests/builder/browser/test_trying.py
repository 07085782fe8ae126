"""A task is tried in the page: what a demonstration looks like, what its failure shows, the map of what can be reached."""

from __future__ import annotations

from collections.abc import Callable

from selenium.webdriver.common.by import By

from rlbench_pin.builder.document import TaskDocument
from tests.builder.browser.conftest import Desk, Sit
from tests.builder.browser.page import until

WALLS = "".join(
    f'\n[[body]]\nname = "wall{number}"\nasset = "objects/cube/cube.urdf"\nfixed = true\n'
    f'parent = "saucepan"\npose = [{x}, {y}, 0.27]\nscale = 2.0\n'
    for number, (x, y) in enumerate([(0.09, 0.0), (-0.09, 0.0), (0.0, 0.09), (0.0, -0.09)])
)
RED = [230, 40, 40]


def _drawn(desk: Desk) -> list[str]:
    """Return the names of all nodes in the page's scene."""
    return list(desk.page.browser.execute_script("return Object.keys(window.__viserSceneTree.getState())"))


def _colors(desk: Desk, body: str) -> list[object]:
    """Return the colours of the meshes of a body in the page's scene."""
    script = """
    return Object.entries(window.__viserSceneTree.getState())
      .filter(([name, node]) => name.startsWith(arguments[0]) && node.message?.props?.color)
      .map(([name, node]) => [...node.message.props.color]);
    """
    return list(desk.page.browser.execute_script(script, f"/bodies/{body}/"))


def _instant(desk: Desk) -> str:
    return str(desk.page.browser.execute_script("return document.querySelector('.instant')?.innerText ?? ''"))


def _images(desk: Desk) -> list[str]:
    """Return the addresses of the images in the tab that is open."""
    images = desk.page.browser.find_elements(By.CSS_SELECTOR, "img")
    return [address for image in images if image.is_displayed() and (address := image.get_attribute("src") or "")]


def _allowed(sit: Sit, document: TaskDocument) -> Desk:
    """Open a task, and let its code run."""
    desk = sit(document)
    desk.settle()
    desk.page.quiet()
    desk.page.tab("Try")
    desk.page.press(f"Run the code of {document.name}.py")
    until(lambda: desk.session.status.opened is not None and desk.session.status.opened.conditions, "the task runs")
    desk.settle()
    return desk


def test_a_demonstration_is_looked_at(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """Played, paused, gone through step by step, with the five cameras; an edit brings the scene at rest back."""
    desk = _allowed(sit, copied("reach_target"))
    page, player = desk.page, desk.window.player
    page.press("Demonstration")
    until(lambda: player.recording.frames and player.recording.frames[-1].success, "success")
    desk.settle()
    last = len(player.recording.frames)
    until(lambda: f"frame {last} of {last}" in _instant(desk), "the end is shown")
    page.press("Play")
    until(lambda: player.timeline.playing, "time goes on, from the beginning")
    page.press("Pause")
    until(lambda: not player.timeline.playing, "time stands still")
    here = player.timeline.index
    page.press("step >")
    until(lambda: f"frame {here + 2} of {last}" in _instant(desk), "the next frame")
    page.press("< segment")
    until(lambda: "frame 1 of" in _instant(desk), "the beginning")
    page.fold("Cameras")
    page.check("Live")
    until(lambda: len(_images(desk)) == 5, "five images")
    before = _images(desk)
    page.press("segment >")
    until(lambda: len(_images(desk)) == 5 and all(a != b for a, b in zip(before[:2], _images(desk), strict=False)), "others")
    page.screenshot("cameras")
    desk.settle()
    shown = _images(desk)
    desk.session.post(lambda: desk.session.do(lambda document: document.set("target", "pose", (0.1, 0.2, 0.3, 0, 0, 0, 1))))
    until(lambda: _images(desk) != shown and len(_images(desk)) == 5, "images of the scene at rest")
    assert page.errors() == []


def test_a_failure_is_shown_where_it_is(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """The validator finds it, one click opens its seed, and what touches what is red until another instant is shown."""
    document = copied("take_lid_off_saucepan")
    document.set_scene_text(document.scene_text + WALLS)
    desk = _allowed(sit, document)
    page, validation, player = desk.page, desk.window.validation, desk.window.player
    page.tab("Validate")
    page.type("Demonstrations", "1")
    page.press("Validate")
    until(lambda: validation.work, "validating")
    until(lambda: not validation.work, "validated", 300.0)
    seed, variation, _ = next(failure for line in validation.lines.values() for failure in line.failures)
    page.screenshot("validated")
    page.press(f"Open seed {seed}, variation {variation}")
    until(lambda: player.recording.failure is not None, "the failure")
    desk.settle()
    assert desk.window.tryout.seed == seed
    failure = player.recording.failure
    assert failure is not None
    walls = {name.partition("/")[0] for pair in failure.pairs for name in pair if name.startswith("wall")}
    assert walls
    page.tab("Try")
    page.shows("Drawn red at the last instant")
    until(lambda: all(RED in _colors(desk, wall) for wall in walls), "red walls")
    page.screenshot("red")
    desk.session.post(lambda: desk.session.do(lambda document: document.undo()))
    until(lambda: "/bodies/wall0" not in _drawn(desk), "the walls are gone")
    assert page.errors() == []


def test_what_cannot_be_reached_is_shown(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """A start that is refused draws the nearest pose; the map has a point for each layout, on the table."""
    document = copied("take_lid_off_saucepan")
    text = document.scene_text
    document.set_placement("static", True)
    document.set("saucepan", "pose", (0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    desk = _allowed(sit, document)
    page, window = desk.page, desk.window
    page.press("Reset")
    until(lambda: window.player.recording.failure is not None, "a refused start", 120.0)
    desk.settle()
    page.shows("The nearest pose that the tip reaches is drawn amber")
    until(lambda: "/ghosts/nearest reachable pose" in _drawn(desk), "the nearest pose")
    page.screenshot("nearest")
    while document.undoable:
        desk.session.post(lambda: desk.session.do(lambda document: document.undo()))
        assert desk.session.edits.wait(30.0)
    assert document.scene_text == text
    until(lambda: "/ghosts/nearest reachable pose" not in _drawn(desk), "it is gone")
    page.tab("Validate")
    page.press("Reach map")
    until(lambda: window.validation.work, "the map begins")
    until(lambda: not window.validation.work, "the map is done", 300.0)
    points = page.browser.execute_script("return window.__viserSceneTree.getState()['/reach'].message.props.points.byteLength")
    assert points > 0
    page.screenshot("map")
    assert page.errors() == []
