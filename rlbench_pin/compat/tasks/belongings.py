"""What a task of the library keeps in attributes, as views that programs know."""

from __future__ import annotations

from numbers import Number
from typing import Any

import numpy as np

from pyrep.objects.object import view_of
from rlbench_pin.compat.things import Element
from rlbench_pin.sim import Body, Frame, ObjectJoint

PLAIN = (str, bytes, Number, np.ndarray, np.generic)
"""Values that are handed over as they are."""


def belonging(native: object | None, name: str) -> Any:
    """Return what a native task keeps as attribute `name`: a thing of its scene as an object, a plain value as it is.

    Args:
        native: The task, or None when it is not loaded.
        name: A public name; lists and tuples of things are possible, too.

    Raises:
        AttributeError: It keeps nothing of that name that a program could use.
    """
    kept = {} if native is None or name.startswith("_") else vars(native)
    if name not in kept:
        raise AttributeError(name)
    return _view(kept[name], name)


def _view(value: Any, name: str) -> Any:
    if isinstance(value, list | tuple):
        return [_view(item, name) for item in value]
    if isinstance(value, Body | ObjectJoint | Frame):
        return view_of(
            Element("body" if isinstance(value, Body) else "joint" if isinstance(value, ObjectJoint) else "frame", value.name)
        )
    if isinstance(value, PLAIN):
        return value
    raise AttributeError(name)
