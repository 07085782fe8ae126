"""Has a press wait until what was typed just before it is sent: the page alone would send the press in its place."""

from __future__ import annotations

from html import escape

from viser import GuiApi

PAUSE = 70
"""From one thing that is told to the next press [ms]; of what comes within 50 ms, the page of viser sends the last alone."""
_SCRIPT = """
if (!window.pressesWait) {
  window.pressesWait = true;
  const told = 'button, [role=option], input[type=checkbox]', slides = '[role=slider], .mantine-Slider-root';
  const replayed = new WeakSet();
  let free = 0;
  const tell = () => { free = Math.max(free, performance.now() + PAUSE); };
  const slide = (event) => { if (event.target.closest?.(slides)) tell(); };
  document.addEventListener('input', tell, true);
  for (const kind of ['pointermove', 'pointerup', 'keydown']) document.addEventListener(kind, slide, true);
  document.addEventListener('click', (event) => {
    const pressed = event.target.closest?.(told);
    if (!pressed) return;
    if (replayed.delete(pressed)) return;
    const now = performance.now();
    if (now >= free) { tell(); return; }
    event.preventDefault();
    event.stopImmediatePropagation();
    const label = pressed.innerText;
    setTimeout(() => {
      const alike = pressed.isConnected ? [pressed] : [...document.querySelectorAll(told)].filter((e) => e.innerText === label);
      if (alike.length !== 1) return;
      replayed.add(alike[0]);
      alike[0].click();
      replayed.delete(alike[0]);
    }, free - now);
    free += PAUSE;
  }, true);
}
"""
"""Enter in a field is a press of the hidden button of its form, thus it waits as well. A button that is made anew while a press
waits is known by what stands on it, where no other says the same."""


def have_presses_wait(gui: GuiApi) -> None:
    """Put the script into the page; scripts in HTML that comes later run only as answers to events, here of a broken picture."""
    script = escape(_SCRIPT.replace("PAUSE", str(PAUSE)))
    gui.add_html(f'<img src="data:," alt="" style="display:none" onerror="{script}">')


__all__ = ["PAUSE", "have_presses_wait"]
