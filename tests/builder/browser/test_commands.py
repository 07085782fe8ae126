"""The commands that serve a page, as processes of their own: opened in a browser, ended with Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By

from tests.builder.browser.page import until

PATIENCE = 60.0
Serve = Callable[..., "Served"]


class Served:
    """A command that serves a page.

    Args:
        arguments: What stands behind `rlbench-pin`.
        log: Takes what it prints.
    """

    def __init__(self, arguments: Sequence[str], log: Path) -> None:
        self._log = log
        with log.open("w") as file:
            command = [sys.executable, "-u", "-m", "rlbench_pin.cli.main", *arguments]
            self.process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT, start_new_session=True)
        self.address = until(self._address, "the address", PATIENCE)

    @property
    def printed(self) -> str:
        """All that it has printed."""
        return self._log.read_text()

    def _address(self) -> str:
        assert self.process.poll() is None, self.printed
        return next((word for word in self.printed.split() if word.startswith("http://")), "")

    def interrupt(self) -> int:
        """Press Ctrl-C; return the exit code once it and all that it has started are gone."""
        children = psutil.Process(self.process.pid).children(recursive=True)
        os.killpg(self.process.pid, signal.SIGINT)
        code = self.process.wait(20.0)
        _, alive = psutil.wait_procs(children, 5.0)
        assert alive == []
        return code


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Serve]:
    """Start commands; what a test leaves is killed."""
    begun: list[Served] = []

    def start(*arguments: object) -> Served:
        begun.append(Served([str(argument) for argument in arguments], tmp_path / f"{len(begun)}.log"))
        return begun[-1]

    yield start
    for served in begun:
        if served.process.poll() is None:
            os.killpg(served.process.pid, signal.SIGKILL)


def _says(browser: Chrome, text: str) -> None:
    until(lambda: text in browser.find_element(By.TAG_NAME, "body").text, f"the text '{text}'", PATIENCE)


def _ends_cleanly(served: Served) -> None:
    """Ctrl-C is no error, and leaves nothing."""
    began = time.monotonic()
    assert served.interrupt() in (0, 130), served.printed
    assert time.monotonic() - began < 15.0
    assert "Traceback" not in served.printed


def test_the_builder(serve: Serve, browser: Chrome, tmp_path: Path) -> None:
    """A new task, changed in the page: what was not saved is said at the end, and nothing is written. Strangers are refused."""
    served = serve("build", "new_one", "--out", tmp_path / "mine", "--no-browser")
    browser.get(served.address)
    _says(browser, "new_one")
    _says(browser, "Add")
    assert [(label, _status(served.address, **head)) for label, head in STRANGERS.items()] == [
        (label, 403) for label in STRANGERS
    ]
    assert _status(served.address) == 200
    browser.switch_to.new_window("tab")
    browser.get(served.address.rstrip("/")[:-4] + "nope/")
    _says(browser, "has no valid token")
    browser.get("data:text/html,<title>elsewhere</title>")
    script = """
    const done = arguments[1], socket = new WebSocket(arguments[0].replace('http', 'ws'), ['viser-v1.1.1']);
    socket.onopen = () => done('open'); socket.onerror = () => done('refused');
    """
    assert browser.execute_async_script(script, served.address) == "refused"
    _ends_cleanly(served)
    assert not (tmp_path / "mine" / "new_one.py").exists()


def test_a_killed_builder(serve: Serve, browser: Chrome, tmp_path: Path) -> None:
    """What was not saved when it was killed is offered by the next, taken up by a button, and saved."""
    arguments = ("build", "new_one", "--out", tmp_path, "--no-browser")
    served = serve(*arguments)
    _press(browser, served, "Add", "Add waypoint at the tip")
    until(lambda: (tmp_path / ".new_one.draft").is_file(), "the draft", PATIENCE)
    os.killpg(served.process.pid, signal.SIGKILL)
    served.process.wait(10.0)
    served = serve(*arguments)
    _press(browser, served, "Scene", "Apply the draft", "Save")
    until(lambda: (tmp_path / "new_one.py").is_file(), "the files", PATIENCE)
    assert 'name = "waypoint0"' in (tmp_path / "new_one.toml").read_text()
    until(lambda: not (tmp_path / ".new_one.draft").exists(), "no draft", PATIENCE)
    _ends_cleanly(served)


def _click_the_visible(browser: Chrome, path: str) -> bool:
    """Click the first element that is displayed; the tabs that are not open have buttons as well."""
    shown = [element for element in browser.find_elements(By.XPATH, path) if element.is_displayed()]
    for element in shown[:1]:
        element.click()
    return bool(shown)


def _press(browser: Chrome, served: Served, *labels: str) -> None:
    """Open the page of a command, and press what has these labels."""
    browser.get(served.address)
    for label in labels:
        path = f"//*[(self::button or @role='tab') and starts-with(normalize-space(), '{label}')]"
        until(lambda path=path: _click_the_visible(browser, path), label, PATIENCE)  # type: ignore[misc]


STRANGERS: dict[str, dict[str, str]] = {
    "another host": {"host": "evil.example"},
    "another origin": {"origin": "http://evil.example"},
    "no token": {"path": "/"},
    "a wrong token": {"path": "/abcdefgh/"},
}


def _status(address: str, host: str = "", origin: str = "", path: str = "") -> int:
    """Return the status of an answer to a request for the page."""
    parts = urlsplit(address)
    connection = HTTPConnection(parts.hostname or "", parts.port, timeout=10.0)
    headers = {"Host": host or parts.netloc, **({"Origin": origin} if origin else {})}
    connection.request("GET", path or parts.path, headers=headers)
    status = connection.getresponse().status
    connection.close()
    return status


def test_a_task(serve: Serve, browser: Chrome) -> None:
    """`view --live` with a demonstration under way when it is ended."""
    served = serve("view", "reach_target", "--live", "--no-browser")
    browser.get(served.address)
    _says(browser, "reach_target, seed 0")
    button = until(lambda: browser.find_element(By.XPATH, "//button[normalize-space()='Play the demonstration']"), "the button")
    button.click()
    _says(browser, "to waypoint0")
    _ends_cleanly(served)


def test_a_dataset(serve: Serve, browser: Chrome, tmp_path: Path) -> None:
    """`view FOLDER --live` plays what was recorded again, and its slider goes through it."""
    record = ["record", "reach_target", "--episodes", "1", "--out", str(tmp_path / "data"), "--products"]
    done = subprocess.run([sys.executable, "-m", "rlbench_pin.cli.main", *record], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    served = serve("view", tmp_path / "data", "--live", "--no-browser")
    browser.get(served.address)
    _says(browser, "goal reached")
    for label in ("< segment", "step >"):
        browser.find_element(By.XPATH, f"//*[normalize-space(text())='{label}']").click()
    _says(browser, "frame 2 of")
    _ends_cleanly(served)


def test_an_evaluation(serve: Serve, browser: Chrome, tmp_path: Path) -> None:
    """`evaluate --live` shows episodes as they are played; ended in the middle of them."""
    arguments = ("--tasks", "reach_target", "--episodes", "200", "--out", tmp_path / "seen.json")
    served = serve("evaluate", "expert", *arguments, "--live", "--no-browser")
    browser.get(served.address)
    _says(browser, "reach_target, seed")
    until(lambda: browser.execute_script("return document.querySelector('.instant')?.innerText"), "an instant", PATIENCE)
    _ends_cleanly(served)
