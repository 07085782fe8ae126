"""Arrays hold real numbers: complex, text, dates, objects, masked and ragged ones are typed errors."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import compose, pose_to_se3
from rlbench_pin.values import as_array, as_pose, as_rows, as_vector

HOME = np.array([0.0, 0.5, 1.0])
NO_ARRAYS = {
    "complex": HOME.astype(complex),
    "text": ["0", "0.5", "1"],
    "bytes": np.array([b"0", b"1", b"2"]),
    "dates": np.array(["2026-01-01"] * 3, dtype="datetime64[D]"),
    "spans": np.array([1, 2, 3], dtype="timedelta64[s]"),
    "objects": HOME.astype(object),
    "none": [0.0, None, 1.0],
    "huge": [10**400, 0, 0],
    "masked": np.ma.masked_array(HOME, [True, False, False]),
    "list of masked": [np.ma.masked_array(HOME, [True, False, False])],
    "ragged": [[1.0], [1.0, 2.0]],
    "object": object(),
    "mapping": {"a": 1.0},
    "set": {0.0, 1.0, 2.0},
}


@pytest.mark.parametrize("name", NO_ARRAYS)
def test_what_holds_no_real_numbers_is_refused(name: str) -> None:
    """Nothing is turned into numbers silently, and no warning is raised in place of an error."""
    with pytest.raises(InvalidValue, match="the target"):
        as_array(NO_ARRAYS[name], "the target")


def test_arrays_of_any_number_type_become_float64() -> None:
    """Lists, tuples, float16, integers; an unmasked masked array is an array."""
    for value in ([0, 0.5, 1], (0.0, 0.5, 1.0), HOME.astype(np.float16), np.ma.masked_array(HOME)):
        array = as_vector(value, 3, "q")
        assert array.dtype == np.float64
        np.testing.assert_array_equal(array, HOME)
    assert as_vector(HOME, 3, "q") is HOME


def test_shapes_and_places_are_named() -> None:
    """What was wanted, what was given, and where NaN is."""
    with pytest.raises(InvalidValue, match=r"q has to have shape \(3,\), not \(2,\)"):
        as_vector([0.0, 1.0], 3, "q")
    with pytest.raises(InvalidValue, match=r"NaN or infinity is at 1, 2"):
        as_vector([0.0, float("nan"), float("inf")], 3, "q")
    with pytest.raises(InvalidValue, match=r"\(m, 3\) with at least 2 rows"):
        as_rows([HOME], 3, "path", least=2)
    assert as_rows([HOME, HOME], 3, "path").shape == (2, 3)


def test_poses_have_a_rotation() -> None:
    """A quaternion of norm zero is refused, others are brought to length 1, or refused beyond a tolerance."""
    np.testing.assert_allclose(as_pose([1, 2, 3, 0, 0, 0, 2]), [1, 2, 3, 0, 0, 0, 1])
    with pytest.raises(InvalidValue, match="norm zero"):
        as_pose(np.zeros(7))
    with pytest.raises(InvalidValue, match="norm 2.0000, not 1"):
        as_pose([1, 2, 3, 0, 0, 0, 2], tolerance=1e-3)
    with pytest.raises(InvalidValue):
        as_pose([0, 0, 0, 0, 0, 0, float("inf")])


@pytest.mark.parametrize("pose", [np.zeros(7), np.full(7, np.nan), np.zeros(6), [0.0, 0.0, 0.0], np.zeros((2, 7))])
def test_the_pose_conventions_refuse_what_is_no_pose(pose: np.ndarray) -> None:
    """No NaN comes out of `compose` and its like."""
    with pytest.raises(InvalidValue, match="A pose"):
        pose_to_se3(pose)
    with pytest.raises(InvalidValue):
        compose([0, 0, 0, 0, 0, 0, 1], pose)
