"""The page of the builder: the scene, and the panels around it."""

from __future__ import annotations

import threading

from viser import ViserServer

from rlbench_pin.builder.view.contracts import Document, Stage
from rlbench_pin.builder.view.drafts import Drafts
from rlbench_pin.builder.view.dragging import Dragging
from rlbench_pin.builder.view.dropping import DropMark
from rlbench_pin.builder.view.gizmo import Phase
from rlbench_pin.builder.view.panels.adding import Adding
from rlbench_pin.builder.view.panels.behaviour import behaviour_items
from rlbench_pin.builder.view.panels.judging import Judging
from rlbench_pin.builder.view.panels.properties import property_items
from rlbench_pin.builder.view.panels.texts import text_items
from rlbench_pin.builder.view.panels.tree import header_items, tree_items
from rlbench_pin.builder.view.panels.tryout import Tryout
from rlbench_pin.builder.view.reach_marks import ReachMarks
from rlbench_pin.builder.view.scene_view import HANDS, SceneView
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.watch import Watch
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Item, Panel
from rlbench_pin.builder.view.widgets.haste import have_presses_wait
from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.player import Player
from rlbench_pin.viewer.recording import Frame

CAMERA, LOOK_AT = (1.05, -0.6, 1.5), (0.18, 0.0, 0.85)
"""Where one looks from at first [m], and at what."""
_LEFT, _RIGHT, _WIDE = 270.0, 350.0, 720.0
_EVERY = 1.0


class Window:
    """Shows one task in a page; all tabs see and do the same.

    Args:
        viser: The page.
        document: The task.
        stage: Its world.

    Attributes:
        session: What is being edited.
        drafts: What is kept of edits that are not saved.
        watch: Keeps the stage in step.
        view: The scene.
    """

    def __init__(self, viser: ViserServer, document: Document, stage: Stage) -> None:
        self._viser = viser
        self.session = Session(document, self._notify)
        self.drafts = Drafts(self.session)
        self.view = SceneView(viser.scene, self._pick, self._drag)
        self.watch = Watch(self.session, stage, self.view.follow)
        self._dragging = Dragging(self.session, self.view, self.watch, DropMark(viser.scene))
        self._adding, self._spots = Adding(self.session, self.view.tip), ReachMarks(viser.scene)
        self._drawn, self._is_playing, self._is_wide, self._closed = -1, False, False, threading.Event()
        viser.initial_camera.position, viser.initial_camera.look_at = CAMERA, LOOK_AT
        viser.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        viser.gui.set_panel_label(f"{document.name} - task builder")
        self._panels = self._left() | self._right()
        self._add_keys()
        self.session.listen(self._refresh)
        self.session.post(self.session.changed)
        self._disk = threading.Thread(target=self._look_at_disk, name="disk", daemon=True)
        self._disk.start()

    # Parts -----------------------------------------------------------------------------------------------------------

    def _left(self) -> dict[str, Panel]:
        gui, post = self._viser.gui, self.session.post
        side = gui.add_panel()
        scene, add = side.add_tab("Scene"), side.add_tab("Add")
        side.dock_left()
        side.set_width(_LEFT)
        with scene:
            header, tree = gui.add_folder(None), gui.add_folder(None)
        return {"header": Panel(gui, header, post), "tree": Panel(gui, tree, post), "add": Panel(gui, add, post)}

    def _right(self) -> dict[str, Panel]:
        gui, post = self._viser.gui, self.session.post
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_RIGHT)
        have_presses_wait(gui)
        tabs = gui.add_tab_group()
        names = ("Selected", "Behaviour", "Files", "Try", "Judge")
        panels = {name: tabs.add_tab(name) for name in names}
        with panels["Try"]:
            tries = gui.add_folder(None)
            self.player = Player(gui, self.view.figures, self._shown, self._viser.atomic)
        self.tryout = Tryout(self.session, self.watch, self.player, self.view.show_added)
        self.judging = Judging(self.session, self.watch, self.tryout.open_at, self._spots.show)
        return {name: Panel(gui, tries if name == "Try" else panel, post) for name, panel in panels.items()}

    def _add_keys(self) -> None:
        session, gui = self.session, self._viser.gui
        undo = gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl")
        undo.on_trigger(lambda _: session.post(lambda: session.do(lambda document: document.undo())))
        redo = gui.add_command("Redo", hotkey="Y", modifier="cmd/ctrl")
        redo.on_trigger(lambda _: session.post(lambda: session.do(lambda document: document.redo())))
        save = gui.add_command("Save", hotkey="S", modifier="cmd/ctrl")
        save.on_trigger(lambda _: session.post(session.save))

    # What happens ----------------------------------------------------------------------------------------------------

    def _pick(self, name: str) -> None:
        self.session.post(lambda: self.session.select(name))

    def _drag(self, pose: FloatArray, phase: Phase) -> None:
        self._is_playing = False
        self._dragging.drag(pose, phase)
        self._viser.flush()  # otherwise it waits for more to send, as long as a picture of 60 a second

    def _shown(self, index: int, frame: Frame) -> None:
        """A recording is shown."""
        self._is_playing = True
        self.view.played(frame)
        self.tryout.shown(frame)

    def _back(self) -> None:
        """Show the scene at rest again."""
        self._is_playing, self._drawn = False, -1
        self.tryout.shown(None)
        self.session.changed()

    def _look_at_disk(self) -> None:
        while not self._closed.wait(_EVERY):
            self.session.post(self._take_from_disk, "disk")

    def _take_from_disk(self) -> None:
        """Take over what an editor has written; with edits that are not saved, somebody has to choose."""
        document = self.session.document
        if not document.changed_on_disk():
            return
        if document.undoable == "" or not document.unsaved:
            self.session.do(lambda document: document.reload())
            self.session.tell("Read again", "The files have changed on disk.")
        else:
            self.session.changed()

    def _notify(self, title: str, text: str, bad: bool) -> None:
        for client in self._viser.get_clients().values():
            client.add_notification(title, text, auto_close_seconds=20.0 if bad else 5.0, color="red" if bad else "blue")

    def _refresh(self) -> None:
        """Show everything as it is now; in the thread of edits."""
        session = self.session
        with self._viser.atomic():
            if session.document.step != self._drawn:
                self._drawn, self._is_playing = session.document.step, False
                self.view.show(session.spec)
                self.tryout.shown(None)
            self.view.point_out(session.selected, session.sight.verdicts, session.sight.paths)
        self._viser.flush()
        items: dict[str, list[Item]] = {
            "header": [*self.drafts.items(), *header_items(session)],
            "tree": [*tree_items(session), self._hands_item(), self._shadows_item()],
            "add": self._adding.items(),
            "Selected": property_items(session, self._dragging.snap_now),
            "Behaviour": behaviour_items(session),
            "Files": text_items(session, self._widen),
            "Try": [*self.tryout.items(), Button("Back to the scene", self._back, disabled=not self._is_playing)],
            "Judge": self.judging.items(),
        }
        for name, panel in self._panels.items():
            panel.show(items[name])

    def _widen(self) -> None:
        """Give the panels on the right room for long lines, or take it back."""
        self._is_wide = not self._is_wide
        self._viser.gui.main_panel.set_width(_WIDE if self._is_wide else _RIGHT)

    def _hands_item(self) -> Choice:
        def choose(word: str) -> None:
            self.view.hands = word
            self.session.changed()

        return Choice("Hands at waypoints", self.view.hands, HANDS, choose)

    def _shadows_item(self) -> Check:
        return Check("Shadows", self.view.shadows, self.view.cast_shadows, "Slow where there is no graphics card")

    def close(self) -> None:
        """End all threads and the stage; the page itself stays with whoever made it."""
        self._closed.set()
        self.watch.stop()
        self._adding.close()
        self.judging.close()
        self.player.close()
        self.session.stop()
        self.drafts.close()
