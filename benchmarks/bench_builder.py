"""The task builder in a browser: from what somebody does in the page to what is seen there, beside a plain page of viser.

Goals: a moved body is drawn elsewhere within 100 ms, and what it makes of the waypoints is coloured within 300 ms, on two cores.
Times are on the wall, of a headless Chromium that draws without a graphics card on the cores that serve the page; the last
part of each, `picture`, is the drawing, which a graphics card would do. `python benchmarks/bench_builder.py --out FILE` measures.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from harness import ROOT, Result, main, summary
from page_probe import Note, Probe
from viser import TransformControlsHandle, ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.server import LocalServer
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks.registry import LIBRARY

sys.path.insert(0, str(ROOT))
from tests.builder.browser.page import Page, start_browser, until

TASK, BODY, WAYPOINT, VIOLET = "pick_and_lift", "block", "waypoint1", (1.0, 0.0, 1.0)
PICTURE_GOAL, REACH_GOAL = 0.1, 0.3
NEAR, ALSO_NEAR, FAR = "0.0", "0.05", "0.8"
"""Places of the body along y [m]; the last one is out of reach of the gripper."""
TOWARDS = (1.0, 0.0, 0.0)
"""Along which arrow it is dragged."""
HANDLE = 0.125
"""From the middle of the gizmo to where an arrow is taken [m]."""
SETTLED = 1.0
"""So long after the last change nothing moves any more [s]."""
STEP, FARTHEST = 0.02, 6
"""How far a step drags it [m], and how many steps it is dragged before it is dragged back."""
SENT = ("GuiUpdateMessage", "TransformControlsUpdateMessage")
"""Messages of the page for one input."""
WARM_UP, REPEATS = 3, 20


@dataclass(frozen=True)
class Times:
    """Times of one change, from the event in the page on [s]."""

    seen: float
    """Until it was drawn, or coloured."""
    sent: float
    """Until the page sent it."""
    served: float
    """Until the server had done what it does."""
    arrived: float
    """Until the page had the answer."""
    picture: float
    """Of the time until it was seen, what drawing that one picture took."""


class Desk:
    """A page in a browser, with a probe.

    Args:
        viser: Serves the page.
        address: Where it is.
        page: The browser.
        probe: The probe in it.
    """

    def __init__(self, viser: ViserServer, address: str, page: Page, probe: Probe) -> None:
        self.viser, self.page, self.probe = viser, page, probe
        self.served: list[float] = []
        self._start = 0.0
        page.open(address, room=True)

    def note_served(self) -> None:
        """Take note that the server has done something."""
        self.served.append(time.time())

    async def heard(self, event: object) -> None:
        """Take note that the server has moved what hangs on a gizmo; called after those who do that."""
        self.note_served()

    def type(self, label: str, number: int, text: str) -> None:
        """Put a number into a field, by one event."""
        field = self.page.field(label, number)
        self.page.browser.execute_script("arguments[0].focus(); arguments[0].select()", field)
        time.sleep(SETTLED)
        self.probe.clear()
        self.page.browser.execute_cdp_cmd("Input.insertText", {"text": text})

    def mouse(self, kind: str, place: Sequence[float]) -> None:
        """Send one event of the mouse at a place in the page [px]."""
        held = {"button": "left", "buttons": 1, "clickCount": 1}
        event = {"type": kind, "x": float(place[0]), "y": float(place[1]), **(held if kind != "hover" else {})}
        if kind == "hover":
            event["type"] = "mouseMoved"
        self.page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", event)

    def times(self, done: str, seen: Callable[[float], Note]) -> Times:
        """Return what the change took that was the last event of a kind."""
        self.probe.settle(SETTLED)
        began = self.probe.last("done", lambda value: value == done).at
        sent = next(note.at for note in self.probe.all("sent") if note.at >= began and note.value in SENT)
        found = seen(self.probe.first("arrived", sent).at)
        arrived = self.probe.between("arrived", sent, found.at)[-1].at
        served = next((at for at in self.served if at >= sent), arrived)
        drawn = self.probe.first("drawn", found.at)  # itself, or the one that follows
        return Times(found.at - began, sent - began, min(served, arrived) - began, arrived - began, drawn.value[1] / 1e3)

    def body_drawn(self, arrived: float) -> Note:
        """Return the first image after an answer in which the violet body is nearer to where it ends than to where it was."""
        places = [(note, note.value[3]) for note in self.probe.all("drawn")]
        end = places[-1][1]
        return next(note for note, place in places if note.at > arrived and abs(place - end) < abs(place - self._start))

    def note_start(self) -> None:
        """Take note of where the violet body is seen; a page that rests draws once a second."""
        self.probe.clear()
        time.sleep(1.2 * SETTLED)
        self._start = self.probe.last("drawn").value[3]


# Pages ---------------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def browser_page(server: LocalServer) -> Iterator[Desk]:
    """Open a page in a browser."""
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if chromium is None or driver is None:
        sys.exit("Chromium or its driver is missing: `make test-browser` installs them where it may.")
    browser = start_browser(chromium, driver)
    try:
        probe = Probe(browser)
        yield Desk(server.viser, server.address, Page(browser, server.viser, Path("out/benchmark")), probe)
    finally:
        browser.quit()


@contextlib.contextmanager
def builder_page() -> Iterator[tuple[Desk, Window]]:
    """Open the builder with a task whose one body is violet."""
    with tempfile.TemporaryDirectory() as folder, LocalServer() as server, WorkerClient() as worker:
        for ending in (".toml", ".py"):
            shutil.copy(LIBRARY / f"{TASK}{ending}", folder)
        document = TaskDocument.open(Path(folder) / f"{TASK}.toml")
        document.set(BODY, "color", VIOLET)
        window = Window(server.viser, document, worker)
        try:
            with browser_page(server) as desk:
                desk.page.quiet()
                desk.page.press(f"■ {BODY}")
                until(lambda: window.session.selected == BODY, "the body is selected")
                window.session.listen(desk.note_served)
                gizmo = server.viser.scene.get_handle_by_name("/gizmo")
                assert isinstance(gizmo, TransformControlsHandle)
                gizmo.on_update(desk.heard)
                assert window.world.wait(60.0) and window.session.edits.wait(60.0)
                yield desk, window
        finally:
            window.close()


# Measuring -----------------------------------------------------------------------------------------------------------


def typed(desk: Desk, middle: FloatArray) -> list[Times]:
    """Move the body by a number, to and fro."""
    desk.probe.look_at(desk.page.pixel(middle))
    found = []
    for k in range(WARM_UP + REPEATS):
        desk.note_start()
        desk.type("x y z [m]", 2, (ALSO_NEAR, NEAR)[k % 2])
        found.append(desk.times("input", desk.body_drawn))
    return found[WARM_UP:]


def coloured(desk: Desk) -> list[Times]:
    """Move the body by a number out of reach of the gripper, and back, until the tree shows it."""
    desk.probe.watch_shade(f"◆ {WAYPOINT}")
    found = []
    for k in range(WARM_UP + REPEATS):
        desk.type("x y z [m]", 2, (FAR, NEAR)[k % 2])
        found.append(desk.times("input", lambda began: desk.probe.first("shade", began)))
    return found[WARM_UP:]


def dragged(desk: Desk, middle: FloatArray) -> list[Times]:
    """Drag the violet body along an arrow of its gizmo, in steps of two centimetres, to and fro."""
    along, canvas = np.array(TOWARDS), desk.page.canvas_middle()
    desk.probe.look_at(desk.page.pixel(middle + along * 0.5 * STEP * FARTHEST))
    place = [canvas + desk.page.pixel(middle + along * (HANDLE + STEP * k)) for k in range(FARTHEST + 1)]
    desk.mouse("hover", place[0])
    time.sleep(SETTLED)
    desk.mouse("mousePressed", place[0])
    time.sleep(SETTLED)
    found = []
    for k in range(WARM_UP + REPEATS):
        desk.note_start()
        desk.mouse("mouseMoved", place[FARTHEST - abs((k + 1) % (2 * FARTHEST) - FARTHEST)])
        found.append(desk.times("pointermove", desk.body_drawn))
    desk.mouse("mouseReleased", place[FARTHEST - abs((WARM_UP + REPEATS) % (2 * FARTHEST) - FARTHEST)])
    time.sleep(SETTLED)
    return found[WARM_UP:]


def plain_page() -> list[Times]:
    """Drag a violet box in a page of viser that has nothing else and a server that does nothing else."""
    with LocalServer() as server:
        scene = server.viser.scene
        scene.set_up_direction("+z")
        scene.configure_environment_map(None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_frame("/room")
        box = scene.add_box("/box", color=(255, 0, 255), dimensions=(0.1, 0.1, 0.1))
        gizmo = scene.add_transform_controls("/gizmo", 0.14, depth_test=False)
        server.viser.initial_camera.position, server.viser.initial_camera.look_at = (0.8, -0.6, 0.65), (0.0, 0.0, 0.0)
        with browser_page(server) as desk:

            @gizmo.on_update
            async def _(event: object) -> None:
                box.position = gizmo.position
                await desk.heard(event)

            return dragged(desk, np.zeros(3))


# Report --------------------------------------------------------------------------------------------------------------


def result(name: str, found: Sequence[Times], goal: float, plain: float | None = None) -> Result:
    """Sum up what was measured, with its parts."""
    parts = {part: 1e3 * float(np.median([getattr(times, part) for times in found])) for part in Times.__annotations__}
    shares = (
        f"sent {parts['sent']:.0f}, served {parts['served'] - parts['sent']:.0f}, back {parts['arrived'] - parts['served']:.0f}, "
        f"then {parts['seen'] - parts['arrived']:.0f} in the page; one picture {parts['picture']:.0f}"
    )
    within = 100.0 * float(np.mean([times.seen <= goal for times in found]))
    note = f"{within:.0f} % within {1e3 * goal:.0f} ms; {shares}"
    extra = {**parts, "within": within, "load": os.getloadavg()[0]}
    if plain is not None:
        extra["ratio"] = parts["seen"] / (1e3 * plain)
        note += f"; {extra['ratio']:.1f} x the plain page"
    return summary(name, [times.seen for times in found], note, **extra)


def benchmark() -> list[Result]:
    """Measure everything."""
    reference = plain_page()
    plain = float(np.median([times.seen for times in reference]))
    results = [result("plain viser page, box dragged", reference, PICTURE_GOAL)]
    with builder_page() as (desk, window):
        for shadows in (False, True):
            window.view.cast_shadows(shadows)
            time.sleep(SETTLED)
            found = dragged(desk, window.session.places.elements[BODY][:3])
            looks = ", with shadows" if shadows else ""
            results.append(result(f"builder, body dragged{looks}", found, PICTURE_GOAL, plain))
        window.view.cast_shadows(False)
        desk.type("x y z [m]", 1, NEAR)
        found = typed(desk, window.session.places.elements[BODY][:3])
        results.append(result("builder, number typed", found, PICTURE_GOAL, plain))
        results.append(result("builder, waypoint coloured", coloured(desk), REACH_GOAL, plain))
    return results


if __name__ == "__main__":
    main(__doc__, benchmark)
