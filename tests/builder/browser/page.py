"""A browser in front of the builder's page: finds controls by their labels, as a person does."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from viser import ViserServer

Found = TypeVar("Found")
PATIENCE = 60.0
"""Time limit for an element to appear [s]: the browser draws without a graphics card."""
_OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--window-size=1180,760",
)


def start_browser(chromium: str, driver: str) -> webdriver.Chrome:
    """Return a browser without a display."""
    options = webdriver.ChromeOptions()
    for option in _OPTIONS:
        options.add_argument(option)
    options.binary_location = chromium
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    browser.set_page_load_timeout(PATIENCE)
    browser.set_script_timeout(PATIENCE)
    return browser


def until(ask: Callable[[], Found], what: str, patience: float = PATIENCE) -> Found:
    """Ask again and again until there is an answer; what the browser cannot say yet counts as none."""
    end, last = time.monotonic() + patience, ""
    while time.monotonic() < end:
        try:
            if answer := ask():
                return answer
        except WebDriverException as error:
            last = str(error.msg)
        time.sleep(0.1)
    raise AssertionError(f"{what}: not within {patience:g} s. {last}")


class Page:
    """The page of a builder in a browser.

    Args:
        browser: The browser.
        viser: The page as the server knows it: where its camera stands.
        images: Folder for images of the steps.
    """

    def __init__(self, browser: webdriver.Chrome, viser: ViserServer, images: Path) -> None:
        self.browser, self._viser, self._folder = browser, viser, images

    def open(self, address: str, room: bool = False) -> None:
        """Open the page, and wait until it shows the scene, with the room or without."""
        self.browser.get(address)
        self._show_room(room)
        until(lambda: self._viser.get_clients(), "a client")
        until(lambda: self.browser.find_elements(By.TAG_NAME, "canvas"), "the scene")

    def screenshot(self, name: str) -> Path:
        """Keep an image of the page."""
        self._folder.mkdir(parents=True, exist_ok=True)
        file = self._folder / f"{name}.png"
        self._show_room(True)
        until(lambda: self.browser.save_screenshot(str(file)), "a screenshot")
        self._show_room(False)
        return file

    def _show_room(self, visible: bool) -> None:
        """Show the room in images alone: without a graphics card it takes most of the time."""
        room = self._viser.scene.get_handle_by_name("/room")
        assert room is not None
        room.visible = visible

    def quiet(self) -> None:
        """Close the messages that lie over the scene."""
        for button in self.browser.find_elements(By.CSS_SELECTOR, ".mantine-Notification-closeButton"):
            self.browser.execute_script("arguments[0].click()", button)

    # Panels ----------------------------------------------------------------------------------------------------------

    def _visible(self, path: str, what: str) -> WebElement:
        def find() -> WebElement | None:
            return next((e for e in self.browser.find_elements(By.XPATH, path) if e.is_displayed()), None)

        found = until(find, what)
        assert found is not None
        return found

    def press(self, label: str) -> None:
        """Press a button."""
        said = "normalize-space(translate(., '\u2003', ' '))"
        path = f"//button[{said}={_quoted(label)} and not(@role='tab') and not(@disabled)]"
        self._click(path, f"button '{label}'")

    def tab(self, label: str) -> None:
        """Open a tab."""
        self._click(f"//*[@role='tab' and normalize-space()={_quoted(label)}]", f"tab '{label}'")

    def fold(self, label: str) -> None:
        """Open or close a fold."""
        self._click(f"//*[normalize-space(text())={_quoted(label)}]", f"fold '{label}'")

    def _click(self, path: str, what: str) -> None:
        def click() -> bool:
            element = self._visible(path, what)
            self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
            element.click()
            return True

        until(click, what)

    def field(self, label: str, number: int = 1) -> WebElement:
        """Return the input behind a label; the second or third of several."""
        path = f"(//label[normalize-space()={_quoted(label)}]/following::*[self::input or self::textarea])[{number}]"
        return self._visible(path, f"field '{label}'")

    def type(self, label: str, text: str, number: int = 1) -> None:
        """Type into a field, in place of what is there."""

        def write() -> bool:
            element = self.field(label, number)
            self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
            element.click()
            element.send_keys(Keys.CONTROL, "a")
            element.send_keys(text)
            return True

        until(write, f"field '{label}'")

    def paste(self, label: str, text: str) -> None:
        """Put a text into a field at once, in place of what is there."""
        element = self.field(label)
        self.browser.execute_script("arguments[0].focus(); arguments[0].select()", element)
        self.browser.execute_cdp_cmd("Input.insertText", {"text": text})

    def upload(self, file: Path, number: int = 0) -> None:
        """Give a file to a button that takes one; the second or third of several."""
        self.browser.find_elements(By.CSS_SELECTOR, "input[type='file']")[number].send_keys(str(file))

    @property
    def text(self) -> str:
        """All that the page says."""
        return self.browser.find_element(By.TAG_NAME, "body").text

    def errors(self) -> list[str]:
        """Return what the browser's console has as errors since the last time.

        Values that arrive for a field that was just taken out are passed over by the page, which says so there.
        """
        said = [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]
        return [text for text in said if "Tried to update non-existent component" not in text]

    def new_tab(self, address: str) -> str:
        """Open a second tab, and return its handle; it is the one that is looked at from now on."""
        before = len(self._viser.get_clients())
        self.browser.switch_to.new_window("tab")
        self.browser.get(address)
        until(lambda: len(self._viser.get_clients()) > before, "a second client")
        return str(self.browser.current_window_handle)

    def choose(self, label: str, option: str) -> None:
        """Choose one of several."""

        def pick() -> bool:
            self.field(label).click()
            path = f"//*[@role='option' and normalize-space()={_quoted(option)}]"
            shown = [e for e in self.browser.find_elements(By.XPATH, path) if e.is_displayed()]
            if shown:
                shown[0].click()
            return bool(shown)

        until(pick, f"option '{option}' of '{label}'")

    def check(self, label: str) -> None:
        """Turn a switch."""
        self._click(f"//label[normalize-space()={_quoted(label)}]/following::input[@type='checkbox'][1]", f"switch '{label}'")

    def shows(self, text: str, patience: float = PATIENCE) -> None:
        """Wait until the page says something."""
        until(lambda: text in self.text, f"the text '{text}'", patience)

    # The scene -------------------------------------------------------------------------------------------------------

    def canvas_middle(self) -> np.ndarray:
        """Return where the middle of the canvas is in the page (2,) [px]."""
        box = self.browser.find_element(By.TAG_NAME, "canvas").rect
        return np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])

    def pixel(self, point: np.ndarray) -> tuple[float, float]:
        """Return where a world point (3,) is seen, from the middle of the canvas [px]."""
        camera = next(iter(self._viser.get_clients().values())).camera
        w, x, y, z = camera.wxyz
        rotation = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        local = rotation.T @ (np.asarray(point) - camera.position)
        canvas = self.browser.find_element(By.TAG_NAME, "canvas").size
        factor = canvas["height"] / (2.0 * np.tan(camera.fov / 2.0))
        return factor * local[0] / local[2], factor * local[1] / local[2]

    def click_until(self, point: np.ndarray, ask: Callable[[], bool], what: str) -> None:
        """Click on a world point (3,) until that has an effect: the scene may not be drawn yet."""

        def click() -> bool:
            self.click_at(point)
            until(ask, what, 5.0)
            return True

        for _ in range(10):
            try:
                until(click, what)
                return
            except AssertionError:
                continue
        raise AssertionError(what)

    def click_at(self, point: np.ndarray) -> None:
        """Click on a world point (3,)."""
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        x, y = self.pixel(point)
        ActionChains(self.browser).move_to_element_with_offset(canvas, round(x), round(y)).pause(0.3).click().perform()

    def drag(self, start: np.ndarray, end: np.ndarray, steps: int = 4) -> None:
        """Take what is seen at a world point (3,), and let it go at another."""
        canvas = self.browser.find_element(By.TAG_NAME, "canvas")
        a, b = np.array(self.pixel(start)), np.array(self.pixel(end))
        chain = ActionChains(self.browser, duration=100).move_to_element_with_offset(canvas, round(a[0]), round(a[1])).pause(1.0)
        chain = chain.click_and_hold().pause(0.5)
        for step in range(1, steps + 1):
            x, y = np.round(a + (b - a) * step / steps).astype(int).tolist()
            chain = chain.move_to_element_with_offset(canvas, x, y).pause(0.4)
        chain.release().perform()


def _quoted(text: str) -> str:
    return f'"{text}"'
