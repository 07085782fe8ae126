"""The page of `view --live`: the scene, the player, the cameras, and what is to be said."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from html import escape

import numpy as np
from numpy.typing import NDArray
from viser import ViserServer

from rlbench_pin.builder.contracts import Frame
from rlbench_pin.builder.figures import Figures
from rlbench_pin.builder.playback.cameras import CameraPanel
from rlbench_pin.builder.playback.player import Player
from rlbench_pin.builder.playback.readout import framed
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene.spec import BodySpec, SceneSpec

_EYE, _TARGET = (1.3, 0.9, 1.65), (0.15, 0.0, 0.95)
"""Where a new tab looks from and to [m]: over the table from the robot's left."""
_LEFT, _RIGHT = 300.0, 360.0
"""Widths of the panels [px]."""


class LivePage:
    """What all live views show, whatever they look at.

    Args:
        server: Serves the page.
        build_controls: Called where the controls of the view belong, above the player.
        on_look: Called when the pictures of the cameras are to be taken anew: another instant is shown, or they were switched on.
        cameras: Whether the pictures are on at first.

    Attributes:
        gui: Where controls are drawn.
        player: Shows recordings.
    """

    def __init__(
        self, server: ViserServer, build_controls: Callable[[], None], on_look: Callable[[], None], cameras: bool = True
    ) -> None:
        self.gui, self._on_look = server.gui, on_look
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        server.initial_camera.position, server.initial_camera.look_at = _EYE, _TARGET
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(_RIGHT)
        self._figures = Figures(server.scene)
        self._words = server.gui.add_html("")
        self._progress = server.gui.add_progress_bar(0.0, visible=False)
        build_controls()
        self.player = Player(server.gui, self._figures, self._shown, server.atomic)
        side = server.gui.add_panel()
        with side.add_tab("Cameras"):
            self._cameras = CameraPanel(server.gui, on_look, cameras)
        side.dock_left()
        side.set_width(_LEFT)

    def _shown(self, index: int, frame: Frame) -> None:
        if self._cameras.wanted:
            self._on_look()

    def show_scene(self, spec: SceneSpec, added: Sequence[BodySpec] = ()) -> None:
        """Draw the bodies of a scene, and those that an episode adds to it."""
        faults = self._figures.show(spec.model_copy(update={"body": (*spec.body, *added)}))
        if faults:
            self.say("Not drawn:", "; ".join(f"{name}: {why}" for name, why in faults.items()), wrong=True)

    @property
    def pictures_wanted(self) -> bool:
        """Whether somebody wants to see what the cameras see."""
        return self._cameras.wanted

    def show_pictures(self, pictures: Mapping[str, NDArray[np.uint8]]) -> None:
        """Show what the cameras see, pictures (h, w, 3) by name."""
        if self._cameras.wanted:
            self._cameras.show(pictures)

    @property
    def words(self) -> str:
        """What was said last, as HTML."""
        return self._words.content

    def say(self, title: str, text: str, *, wrong: bool = False) -> None:
        """Say something above the controls; it takes the place of what was said before."""
        color = "#d93025" if wrong else "inherit"
        self._words.content = framed(f'<div class="words" style="color:{color}"><b>{escape(title)}</b> {escape(text)}</div>')

    @contextmanager
    def computing(self, title: str) -> Iterator[Callable[[float], None]]:
        """Say for the duration of a block that something is being computed, and yield what shows how much is done, 0 to 1.

        Args:
            title: What it is.
        """
        self.say(title, "is being computed. It can be looked at meanwhile; pictures of the cameras follow.")
        self._show_progress(0.0)
        self._progress.visible = True
        try:
            yield self._show_progress
        finally:
            self._progress.visible = False

    def _show_progress(self, share: float) -> None:
        self._progress.value = round(100.0 * min(max(share, 0.0), 1.0))  # type: ignore[misc]

    def fail(self, error: Exception) -> None:
        """Say what went wrong."""
        kind = "" if isinstance(error, RlbenchPinError) else f"{type(error).__name__}: "
        self.say("That failed.", f"{kind}{error}", wrong=True)
