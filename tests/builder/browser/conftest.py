"""A browser for the tests of this folder; where there is none, they are skipped with the reason."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from selenium.webdriver import Chrome

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.server import LocalServer
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.tasks.registry import LIBRARY
from tests.builder.browser.page import Page, start_browser

IMAGES = Path(__file__).parents[3] / "out" / "browser"
"""Where images of the steps are kept."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark everything here."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="session")
def browser_programs() -> tuple[str, str]:
    """Chromium and its driver."""
    pytest.importorskip("selenium", reason="selenium is not installed")
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("Chromium or its driver is missing: `make test-browser` installs them where it may (root, apt-get)")
    return chromium, driver


@pytest.fixture(scope="session")
def shared_browser(browser_programs: tuple[str, str]) -> Iterator[Chrome]:
    """One browser for all tests; see `browser`."""
    made = start_browser(*browser_programs)
    yield made
    made.quit()


@pytest.fixture
def browser(shared_browser: Chrome) -> Iterator[Chrome]:
    """The browser with one empty tab, and a console without old messages."""
    first, *others = shared_browser.window_handles
    for other in others:
        shared_browser.switch_to.window(other)
        shared_browser.close()
    shared_browser.switch_to.window(first)
    shared_browser.get("about:blank")
    shared_browser.get_log("browser")
    yield shared_browser


class Desk:
    """A builder with a page in a browser.

    Args:
        document: The task that is edited.
        page: Opens the page.
        window: What the page shows.
        address: Where it is.
    """

    def __init__(self, document: TaskDocument, page: Page, window: Window, address: str) -> None:
        self.document, self.page, self.window, self.address = document, page, window, address
        self.session = window.session

    def settle(self) -> None:
        """Wait until everything was done that was asked for."""
        assert self.session.edits.wait(120.0)
        assert self.window.world.wait(120.0)
        assert self.session.edits.wait(120.0)


Sit = Callable[[TaskDocument], Desk]
"""Opens a document in a browser."""


@pytest.fixture
def sit(browser: Chrome, request: pytest.FixtureRequest) -> Iterator[Sit]:
    """Open a document in a browser; everything is closed afterwards."""
    ends: list[Callable[[], object]] = []

    def open_desk(document: TaskDocument) -> Desk:
        server, worker = LocalServer(), WorkerClient()
        ends.extend([server.stop, worker.close])
        window = Window(server.viser, document, worker)
        ends.append(window.close)
        ends.append(lambda: browser.get("about:blank"))
        page = Page(browser, server.viser, IMAGES / request.node.name)
        ends.append(lambda: page.screenshot("last"))
        page.open(server.address)
        return Desk(document, page, window, server.address)

    yield open_desk
    for end in reversed(ends):
        end()


@pytest.fixture
def copied(tmp_path: Path) -> Callable[[str], TaskDocument]:
    """Open a copy of a task of the library."""

    def copy(name: str) -> TaskDocument:
        for ending in (".toml", ".py"):
            shutil.copy(LIBRARY / f"{name}{ending}", tmp_path)
        return TaskDocument.open(tmp_path / f"{name}.toml")

    return copy
