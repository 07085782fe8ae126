"""Nothing is lost when a press follows at once upon letters or a choice."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.builder.document import TaskDocument
from tests.builder.browser.conftest import Desk, Sit
from tests.builder.browser.page import until

LETTERS = """
const [field, button, text] = arguments;
const put = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set;
for (let n = 1; n <= text.length; n++) {
  put.call(field, text.slice(0, n));
  field.dispatchEvent(new Event('input', {bubbles: true}));
}
(button || field.form.querySelector('button[type=submit]')).click();
"""
"""Types and presses within a millisecond; Enter presses the hidden button of the form."""


def test_letters_before_a_press(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """The body has its whole name, by the button and by Enter, and one press counts once."""
    desk = sit(copied("reach_target"))
    _rename(desk, "target", "long_name", by_button=True)
    _rename(desk, "long_name", "other_name", by_button=False)
    assert desk.page.errors() == []


def _rename(desk: Desk, old: str, new: str, by_button: bool) -> None:
    page, session = desk.page, desk.session
    session.post(lambda: session.select(old))
    desk.settle()
    until(lambda: page.field("Name").get_attribute("value") == old, "the name")
    button = page.browser.find_element("xpath", "//button[normalize-space()='Rename']") if by_button else None
    steps = desk.document.step
    page.browser.execute_script(LETTERS, page.field("Name"), button, new)
    until(lambda: f'name = "{new}"' in desk.document.scene_text, f"the name {new}", 15.0)
    assert desk.document.step == steps + 1
