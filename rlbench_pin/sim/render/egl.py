"""OpenGL without a display, through PyBullet's EGL plugin."""

from __future__ import annotations

import importlib.util
from typing import Literal, get_args

from rlbench_pin.errors import CameraError

RendererName = Literal["cpu", "egl", "auto"]
RENDERERS: tuple[str, ...] = get_args(RendererName)
_HINT = "Use renderer='cpu', or renderer='auto' to fall back by itself; `rlbench-pin doctor` shows what works here."


class EglMissing(CameraError):
    """EGL was asked for where there is none."""

    def __init__(self, cause: str) -> None:
        self.cause = cause
        super().__init__(f"The EGL renderer cannot be used: {cause}. {_HINT}")


def plugin_file() -> str:
    """Return the file of the plugin.

    Raises:
        EglMissing: PyBullet came without it.
    """
    spec = importlib.util.find_spec("eglRenderer")
    if spec is None or spec.origin is None:
        raise EglMissing("this PyBullet has no eglRenderer plugin")
    return spec.origin
