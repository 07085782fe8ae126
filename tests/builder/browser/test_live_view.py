"""`view --live` in a browser: a demonstration is played, stepped through and looked at from a second tab."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import pytest
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from rlbench_pin.builder.server import LocalServer
from rlbench_pin.tasks import find_task
from rlbench_pin.viewer.live import TaskView
from tests.builder.browser.conftest import IMAGES
from tests.builder.browser.page import Page, until


@pytest.fixture
def server() -> Iterator[LocalServer]:
    """A page that shows nothing yet."""
    with LocalServer() as made:
        yield made


@pytest.fixture
def page(browser: Chrome, server: LocalServer) -> Page:
    """A browser."""
    return Page(browser, server.viser, IMAGES / "live_view")


def _instant(page: Page) -> str:
    """Return what the page says of the instant that it shows."""
    return str(page.browser.execute_script("return document.querySelector('.instant').innerText"))


def test_a_demonstration_is_played_and_stepped_through(page: Page, server: LocalServer) -> None:
    """The time line obeys buttons, keys and the slider's number; a second tab sees the same instant."""
    with contextlib.closing(TaskView(server.viser, find_task("reach_target"), seed=3)) as view:
        page.open(server.address)
        page.shows("Move the gripper to the red ball.")
        page.press("Play the demonstration")
        page.shows("frame 54 of 54")
        page.shows("goal reached")
        page.screenshot("end")
        page.press("< segment")
        until(lambda: "frame 1 of 54" in _instant(page), "the beginning of the segment")
        page.press("step >")
        until(lambda: "frame 2 of 54" in _instant(page), "the second frame")
        assert view.page.player.timeline.index == 1
        page.type("Frame", f"30{Keys.ENTER}", 2)
        until(lambda: "frame 31 of 54" in _instant(page), "frame 31")
        page.fold("Joints")
        page.screenshot("middle")
        assert len(page.browser.find_elements(By.CSS_SELECTOR, "figure img")) == 5
        page.browser.switch_to.new_window("tab")
        page.browser.get(server.address)
        until(lambda: "frame 31 of 54" in _instant(page), "the same instant in the second tab")
        page.press("next")
        until(lambda: view.episode == (4, 0), "the next seed")
        until(lambda: "frame 1 of 1" in _instant(page), "its reset")
