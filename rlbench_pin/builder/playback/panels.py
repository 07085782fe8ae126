"""What a page says of a recording beside the scene: conditions, failure, plots and numbers of the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from viser import GuiApi

from rlbench_pin.builder.contracts import Failure, Frame
from rlbench_pin.builder.playback.readout import conditions_html, failure_html, joints_html, now_style, plot_html

_PLOTS = (("Positions", "rad", "arm"), ("Velocities", "rad/s", "velocities"), ("Torques", "Nm", "torques"))
"""Title, unit and field of frames."""


class ConditionPanel:
    """The success conditions, with a mark for the instant shown and a strip over time.

    Args:
        gui: Where it is drawn.
    """

    def __init__(self, gui: GuiApi) -> None:
        self._html = gui.add_html("")
        self._shown: object = None

    def show(self, texts: Sequence[str], frames: Sequence[Frame], index: int) -> None:
        """Show an instant; nothing is sent where nothing has changed."""
        held = frames[index].held if frames else (False,) * len(texts)
        key = (tuple(texts), held, len(frames), frames[0] if frames else None)
        if key != self._shown:
            self._shown = key
            self._html.content = conditions_html(texts, held, [frame.held for frame in frames])


class FailurePanel:
    """Why a demonstration failed; not there when it did not.

    Args:
        gui: Where it is drawn.
    """

    def __init__(self, gui: GuiApi) -> None:
        self._html = gui.add_html("", visible=False)

    def show(self, failure: Failure | None) -> None:
        """Say why, or nothing."""
        self._html.content = "" if failure is None else failure_html(failure)
        self._html.visible = failure is not None


class JointPanel:
    """Plots of joint positions, velocities and torques, and their numbers at the instant shown.

    Args:
        gui: Where it is drawn.
    """

    def __init__(self, gui: GuiApi) -> None:
        self._numbers = gui.add_html("")
        self._plots = [gui.add_html("") for _ in _PLOTS]

    def draw(self, frames: Sequence[Frame]) -> None:
        """Draw the plots of a recording."""
        for (title, unit, name), html in zip(_PLOTS, self._plots, strict=True):
            html.content = plot_html(title, unit, np.array([getattr(frame, name) for frame in frames])) if frames else ""

    def show(self, frame: Frame) -> None:
        """Show the numbers of an instant."""
        self._numbers.content = joints_html(frame)


class Cursor:
    """The cursors of all strips and plots of a page.

    Args:
        gui: Where it is kept; it is not seen itself.
    """

    def __init__(self, gui: GuiApi) -> None:
        self._html = gui.add_html(now_style(0.0))

    def put(self, share: float) -> None:
        """Put them at an instant, 0 the first to 1 the last."""
        self._html.content = now_style(share)
