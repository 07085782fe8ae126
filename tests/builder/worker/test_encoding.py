"""Records of the builder arrive as they were sent."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.builder.contracts import OpenedTask, PlannedPath, ReachSpot, TaskText, ValidationLine, WaypointVerdict
from rlbench_pin.builder.worker.encoding import decode, encode
from rlbench_pin.evaluation.policies.policy_server import pack, unpack
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.viewer.recording import Failure, Frame, Problem, Recording, Segment

_POSE = np.array([0.1, -0.2, 0.3, 0.0, 0.0, 0.6, 0.8])
_FRAME = Frame(
    0.05,
    {"pan/base": _POSE, "lid/knob": _POSE[::-1].copy()},
    np.arange(7.0),
    np.array([0.04, 0.03]),
    -np.arange(7.0),
    np.ones(7),
    (True, False),
    False,
    {"lid/knob": (1.0, 0.0, 0.5, 1.0)},
)
_FAILURE = Failure("too far", "waypoint1", (("hand", "wall"), ("finger", "wall")), _POSE, Problem("task", 3, "here"))
_RECORDS = (
    OpenedTask(3, ("lid grasped",), ("lid",), ("waypoint0",), (Problem("scene", None, "no TOML"), Problem("task", 4, "a"))),
    Recording(
        (_FRAME, _FRAME),
        ("a", "b"),
        "Lift it.",
        (Segment("waypoint0", 0, "straight"),),
        _FAILURE,
        (BodySpec(name="drop", asset="objects/cube/cube.urdf", color=(1.0, 0.0, 0.0), scale=0.5),),
    ),
    Recording((), (), "", (), None),
    Frame(0.0, {}, np.zeros(7), np.zeros(2), np.zeros(7), np.zeros(7), (), False),
    WaypointVerdict("waypoint0", "collides", "touches", _POSE, np.arange(7.0), _FAILURE),
    WaypointVerdict("waypoint1", "unreachable", "far", _POSE, None, Failure("far")),
    PlannedPath("waypoint0", np.zeros((0, 3)), "", "no way"),
    PlannedPath("waypoint0", np.ones((4, 3)), "straight"),
    ValidationLine("first try", None, "3/4", ((7, 0, "no path"),)),
    ReachSpot((0.1, 0.2, 3.1), (True, False), ((0.1, 0.2), (0.3, 0.4)), True),
    TaskText("pick", Path("/tmp/x"), "format = 2", "import numpy"),
)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.shape == b.shape and bool((a == b).all())
    if isinstance(a, dict):
        return list(a) == list(b) and all(_same(a[key], b[key]) for key in a)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(_same, a, b))
    if is_dataclass(a):
        return type(a) is type(b) and all(_same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return type(a) is type(b) and bool(a == b)


@pytest.mark.parametrize("sent", _RECORDS, ids=lambda sent: type(sent).__name__)
def test_a_record_arrives_as_it_was_sent(sent: object) -> None:
    """Through the very bytes of the connection."""
    message = unpack(pack({"ok": encode(sent)})[4:])
    assert _same(decode(type(sent), message["ok"]), sent)


def test_what_is_no_record_is_refused() -> None:
    """Another map, or a field that there is not."""
    for wrong in ({"nothing": 1}, "text", 3):
        with pytest.raises(ValueError, match="no ValidationLine"):
            decode(ValidationLine, wrong)
