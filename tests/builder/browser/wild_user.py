"""Somebody who presses, types and drags anything, by a seed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tests.builder.browser.conftest import Desk

ODD = (
    *("", "0", "-1", "1e308", "-1e-308", "1e999", "NaN", "Infinity", "0.05", "12", "9" * 400, "a", "block", "root", "world"),
    *(
        "waypoint0",
        "block/base",
        "../../x",
        "'\"\\",
        "ä ö \u202e ß \U0001f916",
        "</textarea><script>alert(1)</script>",
        "[[body]]",
    ),
    *("\t", "name = 1", "%s%n"),
)
_FIND = """
const seen = e => e.offsetParent !== null && !e.disabled && !e.closest('[data-disabled]') && e.type !== 'file';
const found = [...document.querySelectorAll(arguments[0])].filter(seen)
  .filter(e => !arguments[1].some(word => e.innerText?.includes(word)));
if (!found.length) return null;
const one = found[Math.floor(arguments[2] * found.length)];
one.scrollIntoView({block: 'center'});
return one;
"""


class WildUser:
    """Does one action after the other in the page of a desk.

    Args:
        desk: The page.
        seed: Of what is done.
        leave: Words on buttons that are not pressed.

    Attributes:
        done: What was done, in words.
    """

    def __init__(self, desk: Desk, seed: int, leave: tuple[str, ...] = ()) -> None:
        self._desk, self._browser, self._rng = desk, desk.page.browser, np.random.default_rng(seed)
        self._leave = list(leave)
        self.done: list[str] = []
        self._deeds: tuple[tuple[float, Callable[[], str]], ...] = (
            (5.0, self._press), (3.0, self._type), (1.5, self._tab), (1.0, self._switch), (1.0, self._slide), (0.8, self._choose),
            (0.7, self._drag), (0.7, self._click), (0.7, self._undo), (0.4, self._redo),
        )  # fmt: skip

    def act(self, count: int) -> None:
        """Do so many actions."""
        weights = np.array([weight for weight, _ in self._deeds])
        for _ in range(count):
            _, deed = self._deeds[self._rng.choice(len(self._deeds), p=weights / weights.sum())]
            try:
                self.done.append(deed())
            except WebDriverException as error:  # it has gone away meanwhile
                self.done.append(f"{deed.__name__}: {type(error).__name__}")

    def _one(self, selector: str) -> object:
        return self._browser.execute_script(_FIND, selector, self._leave, float(self._rng.random()))

    def _press(self) -> str:
        button = self._one("button:not([role=tab])")
        if button is None:
            return "no button"
        label = self._browser.execute_script("const e = arguments[0], t = e.innerText.trim(); e.click(); return t", button)
        return f"press {label!r}"

    def _tab(self) -> str:
        tab = self._one("[role=tab]")
        return f"tab {self._browser.execute_script('arguments[0].click(); return arguments[0].innerText', tab)!r}"

    def _type(self) -> str:
        field, text = self._one("input[type=text]:not([readonly]), input[inputmode], textarea"), str(self._rng.choice(ODD))
        if field is None:
            return "no field"
        self._browser.execute_script("arguments[0].focus(); arguments[0].select()", field)
        self._browser.execute_cdp_cmd("Input.insertText", {"text": text})
        if self._rng.random() < 0.6:
            ActionChains(self._browser).send_keys(Keys.ENTER).perform()
        return f"type {text[:30]!r}"

    def _switch(self) -> str:
        switch = self._one("input[type=checkbox]")
        if switch is not None:
            self._browser.execute_script("arguments[0].click()", switch)
        return "switch"

    def _slide(self) -> str:
        slider = self._one("[role=slider]")
        if slider is None:
            return "no slider"
        key = str(self._rng.choice([Keys.ARROW_RIGHT, Keys.ARROW_LEFT, Keys.HOME, Keys.END]))
        self._browser.execute_script("arguments[0].focus()", slider)
        ActionChains(self._browser).send_keys(*[key] * int(self._rng.integers(1, 5))).perform()
        return "slide"

    def _choose(self) -> str:
        field = self._one("input[aria-haspopup=listbox]")
        if field is None:
            return "no choice"
        self._browser.execute_script("arguments[0].click()", field)
        option = self._one("[role=option]")
        if option is None:
            return "no option"
        return f"choose {self._browser.execute_script('arguments[0].click(); return arguments[0].innerText', option)!r}"

    def _place(self) -> tuple[int, int]:
        """Return a place on the canvas, from its middle; a handle of the gizmo, where there is one and luck."""
        session = self._desk.session
        pose = session.places.of(session.selected)
        if pose is not None and self._rng.random() < 0.7:
            axis = np.eye(3)[self._rng.integers(3)]
            x, y = self._desk.page.pixel(pose[:3] + 0.125 * axis)
            if abs(x) < 250 and abs(y) < 280:
                return round(x), round(y)
        return int(self._rng.integers(-200, 200)), int(self._rng.integers(-200, 200))

    def _click(self) -> str:
        canvas = self._browser.find_element(By.TAG_NAME, "canvas")
        ActionChains(self._browser, duration=0).move_to_element_with_offset(canvas, *self._place()).pause(0.1).click().perform()
        return "click in the scene"

    def _drag(self) -> str:
        canvas, (x, y) = self._browser.find_element(By.TAG_NAME, "canvas"), self._place()
        chain = ActionChains(self._browser, duration=20).move_to_element_with_offset(canvas, x, y).pause(0.3).click_and_hold()
        for _ in range(3):
            x, y = (int(np.clip(v + self._rng.integers(-60, 60), -240, 240)) for v in (x, y))
            chain = chain.pause(0.1).move_to_element_with_offset(canvas, x, y)
        chain.release().perform()
        return "drag in the scene"

    def _undo(self) -> str:
        self._keys("z", int(self._rng.integers(1, 4)))
        return "undo"

    def _redo(self) -> str:
        self._keys("y", int(self._rng.integers(1, 3)))
        return "redo"

    def _keys(self, key: str, count: int) -> None:
        self._browser.execute_script("document.activeElement?.blur()")
        for _ in range(count):
            ActionChains(self._browser).key_down(Keys.CONTROL).send_keys(key).key_up(Keys.CONTROL).perform()
