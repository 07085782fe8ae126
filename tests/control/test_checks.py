"""What controllers refuse as targets and states."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control.checks import as_placement, as_state, as_vector
from rlbench_pin.errors import ControlError, InvalidTarget


@pytest.mark.parametrize("bad", [[0.0] * 6, [np.nan] * 7, [np.inf] * 7, "hello", None, [[0.0] * 7]])
def test_what_is_no_vector_is_refused(bad: object) -> None:
    """Wrong shapes, NaN, infinity and words raise one typed error that is a ValueError too."""
    with pytest.raises(InvalidTarget) as caught:
        as_vector(bad, 7, "wanted joint velocity")  # type: ignore[arg-type]
    assert isinstance(caught.value, ControlError)
    assert isinstance(caught.value, ValueError)
    assert "wanted joint velocity" in str(caught.value)


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize(("q", "v"), [(np.nan, 0.0), (0.0, np.nan), (np.inf, 0.0), (0.0, -np.inf), (np.inf, np.inf)])
def test_a_state_with_nan_is_refused_whatever_the_other_half(q: float, v: float) -> None:
    """NaN in one of configuration and velocity does not hide behind zeros in the other."""
    with pytest.raises(InvalidTarget):
        as_state(np.full(7, q), np.full(7, v), 7)


def test_lists_make_a_state() -> None:
    """Lists and integers are converted."""
    q, v = as_state([0] * 7, np.ones(7, dtype=np.float32), 7)
    assert q.dtype == v.dtype == np.float64


def test_quaternions_are_brought_to_length_one() -> None:
    """A pose with a quaternion of length 2 means the same rotation."""
    np.testing.assert_allclose(as_placement([1, 2, 3, 0, 0, 2, 0]).rotation, np.diag([-1.0, -1.0, 1.0]), atol=1e-12)


@pytest.mark.parametrize("quaternion", [[0, 0, 0, 0], [1e-9, 0, 0, 0]])
def test_a_quaternion_of_norm_zero_is_refused(quaternion: list[float]) -> None:
    """No direction can be guessed from it."""
    with pytest.raises(InvalidTarget, match="norm zero"):
        as_placement([0.3, 0.0, 1.0, *quaternion])


@pytest.mark.parametrize("place", range(7))
def test_a_pose_with_nan_is_refused(place: int) -> None:
    """Wherever the NaN is."""
    pose = np.array([0.3, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])
    pose[place] = np.nan
    with pytest.raises(InvalidTarget):
        as_placement(pose)
