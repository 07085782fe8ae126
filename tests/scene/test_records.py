"""Records of a scene that are made by hand: what they cannot hold is refused as InvalidRecord, with the key and what would do."""

from __future__ import annotations

import pickle
from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.errors import InvalidRecord, InvalidValue
from rlbench_pin.scene import BodySpec, FrameSpec, JointSpec, PlacementSpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec

WRONG: dict[str, tuple[Callable[[], object], str, str]] = {
    "misspelt key": (lambda: FrameSpec(name="a", prent="world"), "prent", "Did you mean 'parent'?"),
    "strange key": (lambda: FrameSpec(name="a", zzz=1), "zzz", "Known keys: name, parent, pose."),
    "missing key": (lambda: FrameSpec(), "name", "is missing"),
    "bare value": (lambda: FrameSpec("a"), "", "made with keys"),
    "name": (lambda: BodySpec(name="A b", asset="x.urdf"), "name", "a letter first"),
    "long name": (lambda: BodySpec(name="a" * 200, asset="x.urdf"), "name", "at most 100"),
    "pose": (lambda: FrameSpec(name="a", pose=[1.0, 2.0]), "pose", "not 2"),
    "millimetres": (lambda: FrameSpec(name="a", pose=[1000.0, 0.0, 0.0]), "pose.0", "Are these millimetres?"),
    "no number": (lambda: FrameSpec(name="a", pose=[float("nan"), 0.0, 0.0]), "pose.0", "finite"),
    "flat": (lambda: RegionSpec(name="a", size=(0.0, 1.0, 0.0)), "size.0", "greater than 0"),
    "shape": (lambda: SensorSpec(name="a", shape="ball", size=(1.0,)), "shape", "'sphere'"),
    "spring": (lambda: JointSpec(name="a/b", spring={"stiffness": -1.0}), "spring.stiffness", "greater than 0"),
    "one bound": (lambda: PlacementSpec(yaw=(0.0,)), "yaw", "more than 1 items"),
    "word": (lambda: WaypointSpec(name="waypoint0", gripper="opn"), "gripper", "'open' or 'close'"),
    "switch": (lambda: BodySpec(name="a", asset="x.urdf", fixed="yes"), "fixed", "true or false"),
    "inside": (lambda: SceneSpec(format=2, frame=[{"name": "a", "pose": [1.0]}]), "frame.0.pose", "not 1"),
}


@pytest.mark.parametrize(("make", "key", "advice"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_record_is_refused_in_our_words(make: Callable[[], object], key: str, advice: str) -> None:
    """The error names record and key, says what would do, and is a ValueError that can be pickled."""
    with pytest.raises(InvalidRecord) as caught:
        make()
    error = caught.value
    assert isinstance(error, InvalidValue) and isinstance(error, ValueError)
    assert error.key == key
    assert str(error).startswith(error.record)
    assert advice in str(error)
    assert "Input should" not in str(error)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_arrays_do_where_lists_do() -> None:
    """A pose, a size and a colour may be arrays of numpy; what is kept are plain numbers."""
    body = BodySpec(name="a", asset="x.urdf", pose=np.array([1.0, 2.0, 3.0]), color=np.array([0.0, 0.5, 1.0]))
    assert body == BodySpec(name="a", asset="x.urdf", pose=(1.0, 2.0, 3.0), color=(0.0, 0.5, 1.0))
    assert all(type(number) is float for number in body.pose)
    assert RegionSpec(name="a", size=np.array([1.0, 2.0, 0.0])).size == (1.0, 2.0, 0.0)
