"""A probe in a page of the builder: when somebody did something, when that was sent and answered, and when it was drawn."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from selenium.webdriver import Chrome

_SCRIPT = """
(() => {
  const probe = window.builderProbe = {notes: [], box: null, gl: null, drew: false, spent: 0};
  const note = (kind, value, at) => probe.notes.push([performance.timeOrigin + (at ?? performance.now()), kind, value]);
  for (const kind of ['pointermove', 'input'])
    window.addEventListener(kind, event => note('done', kind, event.timeStamp), true);
  window.Worker = class extends window.Worker {
    constructor(...what) {
      super(...what);
      this.addEventListener('message', event => {
        if (event.data?.type === 'message_batch') note('arrived', event.data.messages.length);
      });
    }
    postMessage(message, ...more) {
      if (message?.type === 'send') note('sent', message.message.type);
      super.postMessage(message, ...more);
    }
  };
  const context = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (...what) {
    const made = context.apply(this, what);
    if (what[0] === 'webgl2' && made && !probe.gl && this.isConnected) probe.gl = made;
    return made;
  };
  for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced']) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...what) {
      probe.drew ||= this === probe.gl;
      return draw.apply(this, what);
    };
  }
  // A copy is asked for with the picture and looked at when it is there: the page goes on meanwhile, as it does without a probe.
  const watched = began => {
    const {gl, box: [x, y, w, h]} = probe, buffer = gl.createBuffer(), called = performance.now();
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 4 * w * h, gl.STREAM_READ);
    gl.readPixels(x, y, w, h, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return setTimeout(look, 1);
      const done = performance.now();
      note('drawn', [called - began, done - called, ...counted(buffer, w, h)], done);
      gl.deleteSync(fence);
      gl.deleteBuffer(buffer);
    };
    setTimeout(look, 1);
  };
  const counted = (buffer, w, h) => {
    const {gl} = probe, pixels = new Uint8Array(4 * w * h);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, pixels);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    let violet = 0, sum = 0;
    for (let k = 0; k < pixels.length; k += 4) {
      const r = pixels[k], g = pixels[k + 1], b = pixels[k + 2];
      if (r - g > 70 && b - g > 70) { violet++; sum += (k / 4) % w + ((k / 4) / w | 0); }
    }
    return [violet, violet ? sum / violet : 0];
  };
  const frame = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = work => frame(at => {
    const began = performance.now();
    probe.drew = false;
    work(at);
    if (probe.drew && probe.gl && probe.box) watched(began);
  });
  probe.shade = label => {
    const found = [...document.querySelectorAll('button')].find(e => e.innerText.trim() === label);
    return found ? getComputedStyle(found).backgroundColor : '';
  };
  probe.watchShade = label => {
    let last = probe.shade(label);
    const look = () => { const now = probe.shade(label); if (now !== last) { last = now; note('shade', now); } };
    new MutationObserver(look).observe(document.body, {subtree: true, childList: true, attributes: true});
  };
})();
"""


@dataclass(frozen=True)
class Note:
    """Something that the probe saw."""

    at: float
    """By the clock on the wall [s]."""
    kind: str
    """`done` by a person, `sent`, `arrived`, `drawn`, or `shade` of a button."""
    value: Any
    """What belongs to it; of `drawn`: scripts [ms], drawing [ms], number of violet pixels, and where they are on the whole."""


class Probe:
    """The probe of one page.

    Args:
        browser: A browser that has not opened the page yet.
    """

    def __init__(self, browser: Chrome) -> None:
        self._browser = browser
        self._notes: list[Note] = []
        browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": _SCRIPT})

    def look_at(self, middle: Sequence[float], half: int = 140) -> None:
        """Have a square of every picture read from now on: its middle from that of the canvas, x to the right, y down [px]."""
        script = """
        const {drawingBufferWidth: w, drawingBufferHeight: h} = builderProbe.gl, [x, y, half] = arguments;
        builderProbe.box = [Math.round(w / 2 + x - half), Math.round(h / 2 - y - half), 2 * half, 2 * half];
        """
        self._browser.execute_script(script, float(middle[0]), float(middle[1]), half)

    def watch_shade(self, label: str) -> None:
        """Note from now on when a button takes another colour."""
        self._browser.execute_script("builderProbe.watchShade(arguments[0])", label)

    def clear(self) -> None:
        """Forget what was noted."""
        self._take()
        self._notes.clear()

    def _take(self) -> None:
        script = "return builderProbe.notes.splice(0)"
        self._notes += [Note(at / 1e3, kind, value) for at, kind, value in self._browser.execute_script(script)]

    def settle(self, rest: float) -> None:
        """Wait until nothing has come from the server for a while [s]."""
        end = time.time() + rest
        while time.time() < end:
            time.sleep(0.1)
            self._take()
            end = max([end, *(note.at + rest for note in self._notes if note.kind in ("arrived", "done"))])

    def all(self, kind: str) -> list[Note]:
        """Return all notes of a kind."""
        return [note for note in self._notes if note.kind == kind]

    def first(self, kind: str, after: float) -> Note:
        """Return the first note of a kind at an instant [s] or after."""
        return next(note for note in self.all(kind) if note.at >= after)

    def last(self, kind: str, fits: Callable[[Any], bool] = lambda value: True) -> Note:
        """Return the latest note of a kind whose value fits."""
        self._take()
        return next(note for note in reversed(self.all(kind)) if fits(note.value))

    def between(self, kind: str, began: float, ended: float) -> list[Note]:
        """Return the notes of a kind between two instants [s]."""
        return [note for note in self.all(kind) if began <= note.at <= ended]
