"""Joint limits."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.robot.limits import JointLimits

LIMITS = JointLimits(-np.ones(2), np.ones(2), np.array([0.5, 3.0]), np.array([10.0, 1.0]), np.ones(2))


def test_arrays_cannot_be_changed() -> None:
    """Limits are shared, so nobody may write to them."""
    with pytest.raises(ValueError, match="read-only"):
        LIMITS.lower[0] = 0.0


def test_caps_only_lower() -> None:
    """A cap slows the fast joints down and leaves the slow ones as they are."""
    capped = LIMITS.capped(1.0, 4.0)
    np.testing.assert_array_equal(capped.velocity, [0.5, 1.0])
    np.testing.assert_array_equal(capped.acceleration, [4.0, 1.0])


def test_margin_is_the_distance_to_the_nearest_limit() -> None:
    """The margin is negative outside."""
    assert LIMITS.margin(np.array([0.0, 0.9])) == pytest.approx(0.1)
    assert LIMITS.margin(np.array([-1.2, 0.0])) == pytest.approx(-0.2)
    assert LIMITS.contains(np.array([1.0, -1.0]))
    assert not LIMITS.contains(np.array([1.1, 0.0]))


def test_wrong_shape_is_refused() -> None:
    """All arrays have one length."""
    with pytest.raises(ValueError, match="velocity"):
        JointLimits(-np.ones(2), np.ones(2), np.ones(3), np.ones(2), np.ones(2))
