"""Records of observations: a demonstration that was unpickled without our fields can still be used."""

from __future__ import annotations

import inspect
import pickle

from rlbench_pin import Demo, Observation


def test_an_unpickled_demo_has_every_field() -> None:
    """Fields that the file does not know have the values of a demo that was made without them."""
    old = Demo.__new__(Demo)
    old.__dict__["_observations"] = [Observation(gripper_open=1.0)]
    demo = pickle.loads(pickle.dumps(old))
    assert len(demo) == 1
    assert demo[0].gripper_open == 1.0
    plain = Demo([])
    for name in list(inspect.signature(Demo).parameters)[1:]:
        assert getattr(demo, name) == getattr(plain, name), name
        assert name not in vars(demo)
