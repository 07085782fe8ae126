"""A window on the screen that shows pictures; needs a screen and pygame (`pip install -e '.[human]'` in a clone)."""

from __future__ import annotations

import importlib
import importlib.util
import os
from types import ModuleType

import numpy as np

from rlbench_pin.errors import TaskEnvironmentError, install_hint

_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")


class WindowMissing(TaskEnvironmentError):
    """No window can be opened here."""


def why_no_window() -> str | None:
    """Say what a window lacks here and what to do about it, or None when one can be opened."""
    if not any(os.environ.get(name) for name in _SCREENS):
        return "there is no screen (DISPLAY and WAYLAND_DISPLAY are unset). Use render_mode='rgb_array', or run under `xvfb-run`."
    if importlib.util.find_spec("pygame") is None:
        return f"pygame is not installed. {install_hint('human')} brings it, or use render_mode='rgb_array'."
    return None


class Window:
    """Shows one picture after the other; opens with the first.

    Args:
        title: Stands above the pictures.

    Raises:
        WindowMissing: There is no screen, or no pygame.
    """

    def __init__(self, title: str) -> None:
        reason = why_no_window()
        if reason is not None:
            raise WindowMissing(f"render_mode='human' opens a window, but {reason}")
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        self._pygame: ModuleType = importlib.import_module("pygame")
        self._title, self._open = title, False

    def show(self, picture: np.ndarray) -> None:
        """Show a picture, uint8 (h, w, 3).

        Raises:
            WindowMissing: The screen that the environment variables name does not answer.
        """
        pygame = self._pygame
        height, width = picture.shape[:2]
        if not self._open:
            try:
                pygame.display.init()
                pygame.display.set_mode((width, height))
            except pygame.error as error:
                raise WindowMissing(f"The screen does not answer: {error}. Use render_mode='rgb_array'.") from error
            pygame.display.set_caption(self._title)
            self._open = True
        surface = pygame.surfarray.make_surface(picture.swapaxes(0, 1))
        pygame.display.get_surface().blit(surface, (0, 0))
        pygame.event.pump()
        pygame.display.flip()

    def close(self) -> None:
        """Close the window; may be called again."""
        if self._open:
            self._open = False
            self._pygame.display.quit()
