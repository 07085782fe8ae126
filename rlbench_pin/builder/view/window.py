"""The page of the builder: the scene, and the panels around it."""

from __future__ import annotations

import threading

from viser import ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view.adding import Adding
from rlbench_pin.builder.view.behaviour import show_behaviour
from rlbench_pin.builder.view.dragging import Dragging, DropMark
from rlbench_pin.builder.view.files import show_files
from rlbench_pin.builder.view.properties import show_properties
from rlbench_pin.builder.view.scene_panel import Drafts, show_edits, show_header, show_tree
from rlbench_pin.builder.view.scene_view import GRIPPERS, Phase, SceneView
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.tryout import Tryout
from rlbench_pin.builder.view.validation import Validation
from rlbench_pin.builder.view.widgets import Container, Panel, delay_presses
from rlbench_pin.builder.view.world_sync import WorldSync
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.player import Player
from rlbench_pin.viewer.recording import Frame

CAMERA, LOOK_AT = (1.05, -0.6, 1.5), (0.18, 0.0, 0.85)
"""Initial position and target of the camera [m]."""
_LEFT, _RIGHT, _WIDE = 270.0, 350.0, 720.0
_DISK_INTERVAL = 1.0


class Window:
    """Shows one task in a page; all tabs of the browser share its state.

    Args:
        viser: The page.
        document: The task.
        worker: The worker process that simulates it.

    Attributes:
        session: The edited task.
        drafts: Keeps unsaved edits.
        world: Sends requests to the worker process.
        view: The scene.
        panels: The panels by name.
    """

    def __init__(self, viser: ViserServer, document: TaskDocument, worker: WorkerClient) -> None:
        self._viser = viser
        self.session = Session(document, self._notify)
        self.drafts = Drafts(self.session)
        self.view = SceneView(viser.scene, self._pick, self._drag)
        self.world = WorldSync(self.session, worker, self.view.follow)
        self.drop_mark = DropMark(viser.scene)
        self.dragging = Dragging(self.session, self.view, self.world, self.drop_mark)
        self.adding = Adding(self.session, self.view.tip)
        self._drawn, self._is_playing, self._is_wide, self._closed = -1, False, False, threading.Event()
        viser.initial_camera.position, viser.initial_camera.look_at = CAMERA, LOOK_AT
        viser.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        viser.gui.set_panel_label(f"{document.name} - task builder")
        self.panels = self._left_panels() | self._right_panels()
        self._add_keys()
        self.session.listen(self._refresh)
        self.session.post(self.session.changed)
        self._disk = threading.Thread(target=self._watch_disk, name="disk", daemon=True)
        self._disk.start()

    # Layout ----------------------------------------------------------------------------------------------------------

    def _left_panels(self) -> dict[str, Panel]:
        gui, post = self._viser.gui, self.session.post
        side = gui.add_panel()
        scene, add = side.add_tab("Scene"), side.add_tab("Add")
        side.dock_left()
        side.set_width(_LEFT)
        with scene:
            header, tree = gui.add_folder(None), gui.add_folder(None)
        return {"Header": Panel(gui, header, post), "Tree": Panel(gui, tree, post), "Add": Panel(gui, add, post)}

    def _right_panels(self) -> dict[str, Panel]:
        gui, post = self._viser.gui, self.session.post
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_RIGHT)
        delay_presses(gui)
        edits = gui.add_folder(None)
        tabs = gui.add_tab_group()
        containers: dict[str, Container] = {
            name: tabs.add_tab(name) for name in ("Selected", "Behaviour", "Files", "Try", "Validate")
        }
        with containers["Try"]:
            tryout = gui.add_folder(None)
            self.player = Player(gui, self.view.figures, self._show_frame, self._viser.atomic)
        self.tryout = Tryout(self.session, self.world, self.player, self.view.show_added)
        self.validation = Validation(self.session, self.world, self.tryout.open_at, self.view.show_reach)
        containers = {"Edits": edits, **containers, "Try": tryout}
        return {name: Panel(gui, container, post) for name, container in containers.items()}

    def _add_keys(self) -> None:
        session, gui = self.session, self._viser.gui
        undo = gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl")
        undo.on_trigger(lambda _: session.post(lambda: session.do(lambda document: document.undo())))
        redo = gui.add_command("Redo", hotkey="Y", modifier="cmd/ctrl")
        redo.on_trigger(lambda _: session.post(lambda: session.do(lambda document: document.redo())))
        save = gui.add_command("Save", hotkey="S", modifier="cmd/ctrl")
        save.on_trigger(lambda _: session.post(session.save))

    # Events ----------------------------------------------------------------------------------------------------------

    def _pick(self, name: str) -> None:
        self.session.post(lambda: self.session.select(name))

    def _drag(self, pose: FloatArray, phase: Phase) -> None:
        self._is_playing = False
        self.dragging.drag(pose, phase)
        self._viser.flush()  # without delay

    def _show_frame(self, index: int, frame: Frame) -> None:
        """Show a frame of a recording."""
        self._is_playing = True
        self.view.played(frame)
        self.tryout.set_frame(frame)

    def _back_to_scene(self) -> None:
        self._is_playing, self._drawn = False, -1
        self.tryout.set_frame(None)
        self.session.changed()

    def _watch_disk(self) -> None:
        while not self._closed.wait(_DISK_INTERVAL):
            self.session.post(self.take_from_disk, "disk")

    def take_from_disk(self) -> None:
        """Read files again that an editor has changed; with unsaved edits, the user decides."""
        document = self.session.document
        if not document.changed_on_disk():
            return
        if document.undoable == "" or not document.unsaved:
            self.session.do(lambda document: document.reload())
            self.session.show_message("Read again", "The files have changed on disk.")
        else:
            self.session.changed()

    def _notify(self, title: str, text: str, bad: bool) -> None:
        for client in self._viser.get_clients().values():
            client.add_notification(title, text, auto_close_seconds=20.0 if bad else 5.0, color="red" if bad else "blue")

    # Display ---------------------------------------------------------------------------------------------------------

    def _refresh(self) -> None:
        """Show the current state, in the thread of edits."""
        session = self.session
        with self._viser.atomic():
            if session.document.step != self._drawn:
                self._drawn, self._is_playing = session.document.step, False
                self.view.show(session.spec)
                self.tryout.set_frame(None)
            self.view.point_out(session.selected, session.status.verdicts, session.status.paths)
        self._viser.flush()
        with self.panels["Edits"].update() as panel:
            show_edits(panel, session)
        with self.panels["Header"].update() as panel:
            show_header(panel, session)
            self.drafts.show(panel)
        with self.panels["Tree"].update() as panel:
            show_tree(panel, session)
            panel.dropdown("Grippers at waypoints", self.view.grippers, GRIPPERS, self._set_grippers)
            panel.checkbox("Shadows", self.view.shadows, self.view.cast_shadows, "Slow without a graphics card")
        with self.panels["Add"].update() as panel:
            self.adding.show(panel)
        with self.panels["Selected"].update() as panel:
            show_properties(panel, session, self.dragging.snap_now)
        with self.panels["Behaviour"].update() as panel:
            show_behaviour(panel, session)
        with self.panels["Files"].update() as panel:
            show_files(panel, session, self._widen)
        with self.panels["Try"].update() as panel:
            self.tryout.show(panel)
            panel.button("Back to the scene", self._back_to_scene, disabled=not self._is_playing)
        with self.panels["Validate"].update() as panel:
            self.validation.show(panel)

    def _widen(self) -> None:
        """Make the right panel wider, or narrower again."""
        self._is_wide = not self._is_wide
        self._viser.gui.main_panel.set_width(_WIDE if self._is_wide else _RIGHT)

    def _set_grippers(self, word: str) -> None:
        self.view.grippers = word
        self.session.changed()

    def close(self) -> None:
        """End all threads and the requests; the page stays open."""
        self._closed.set()
        self.world.stop()
        self.adding.close()
        self.validation.close()
        self.player.close()
        self.session.stop()
        self.drafts.close()
