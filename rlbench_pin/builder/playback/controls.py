"""The controls of a player: time line, play and pause, steps, legs, pace."""

from __future__ import annotations

from collections.abc import Callable

from viser import GuiApi, GuiEvent, Icon

from rlbench_pin.builder.playback.timeline import SPEEDS, Timeline

Change = Callable[[Callable[[Timeline], None]], None]
"""Changes the time line and shows what it stands at."""
_WORDS = {f"{speed:g}x": speed for speed in SPEEDS}


class Controls:
    """Draws the controls and passes on what somebody does with them.

    Args:
        gui: Where they are drawn.
        change: Called with what to do with the time line.
    """

    def __init__(self, gui: GuiApi, change: Change) -> None:
        self._change = change
        self._slider = gui.add_slider("Frame", 0, 1, 1, 0, hint="Instant that is shown")
        self._slider.on_update(self._slid)
        self._play = gui.add_button("Play", icon=Icon.PLAYER_PLAY)
        self._play.on_click(lambda _: change(_toggle))
        self._moves = {
            "< leg": lambda timeline: timeline.jump(-1),
            "< step": lambda timeline: timeline.step(-1),
            "step >": lambda timeline: timeline.step(1),
            "leg >": lambda timeline: timeline.jump(1),
        }
        moves = gui.add_button_group("Go", tuple(self._moves))
        moves.on_click(lambda event: change(self._moves[event.target.value]))
        self._speed = gui.add_dropdown("Pace", tuple(_WORDS), initial_value="1x", hint="Simulated seconds in a second")
        self._speed.on_update(self._paced)
        self._add_keys(gui)

    def _add_keys(self, gui: GuiApi) -> None:
        keys = (
            ("Play or pause", "space", _toggle),
            ("Next frame", "arrowright", self._moves["step >"]),
            ("Frame before", "arrowleft", self._moves["< step"]),
        )
        self._commands = [gui.add_command(label, hotkey=key, modifier="shift") for label, key, _ in keys]  # type: ignore[arg-type]
        for command, (_, _, action) in zip(self._commands, keys, strict=True):
            command.on_trigger(lambda _, action=action: self._change(action))  # type: ignore[misc]

    def show(self, timeline: Timeline) -> None:
        """Show where the time line stands."""
        last = max(timeline.last, 1)
        if self._slider.max != last:
            self._slider.max = last
        if (disabled := timeline.last == 0) != self._slider.disabled:
            self._slider.disabled = disabled
        self._slider.value = timeline.index  # type: ignore[misc]  # mypy does not see its setter
        label, icon = ("Pause", Icon.PLAYER_PAUSE) if timeline.playing else ("Play", Icon.PLAYER_PLAY)
        if self._play.label != label:
            self._play.label, self._play.icon = label, icon

    def _slid(self, event: GuiEvent) -> None:
        if event.client is not None:  # otherwise it only shows where time has come to
            index = int(event.target.value)
            self._change(lambda timeline: timeline.seek(index))

    def _paced(self, event: GuiEvent) -> None:
        speed = _WORDS[event.target.value]
        self._change(lambda timeline: timeline.pace(speed))

    def remove_keys(self) -> None:
        """Take the keys out of the page."""
        for command in self._commands:
            command.remove()


def _toggle(timeline: Timeline) -> None:
    if timeline.playing:
        timeline.pause()
    else:
        timeline.play()
