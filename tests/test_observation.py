"""Records of observations: a demonstration that was unpickled without our fields can still be used."""

from __future__ import annotations

# ruff: noqa: NPY002
import inspect
import pickle

import numpy as np
import pytest

from rlbench_pin import Demo, Observation
from rlbench_pin.errors import TaskEnvironmentError


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


@pytest.mark.parametrize("seed", [0, 7, np.int64(12), 2**32 - 1, 2**32, 2**53 - 1])
def test_restoring_the_state_seeds_the_global_generator(seed: int) -> None:
    """The same draws come after each call, as after `numpy.random.seed` with a small seed; a large one is used whole."""
    demo, other = Demo([], random_seed=seed), Demo([], random_seed=int(seed) // 2 + 1)
    demo.restore_state()
    first = np.random.random(4)
    other.restore_state()
    assert (np.random.random(4) != first).all()
    demo.restore_state()
    np.testing.assert_array_equal(np.random.random(4), first)
    if seed < 2**32:
        np.random.seed(seed)
        np.testing.assert_array_equal(np.random.random(4), first)


def test_restoring_a_full_state_repeats_the_draws_after_it() -> None:
    """As for demonstrations whose seed is what `numpy.random.get_state()` returned."""
    np.random.seed(3)
    np.random.normal(size=3)
    demo = Demo([], random_seed=np.random.get_state())
    first = np.random.normal(size=5)
    demo.restore_state()
    np.testing.assert_array_equal(np.random.normal(size=5), first)
    assert demo.seed is None


@pytest.mark.parametrize("seed", [None, -1, 1.5, "seed", ("MT19937", 3), ()])
def test_what_is_no_seed_restores_nothing(seed: object) -> None:
    """The error shows the value and says what is needed; the generator is left alone."""
    before = np.random.get_state()[1].copy()
    with pytest.raises(TaskEnvironmentError, match=r"random_seed=.*whole number >= 0"):
        Demo([], random_seed=seed).restore_state()  # type: ignore[arg-type]
    np.testing.assert_array_equal(np.random.get_state()[1], before)


def test_an_observation_is_copied_from_its_vars() -> None:
    """Also where a demonstration set what observations have only then; thirty values in a row are enough otherwise."""
    plain = Observation(*[None] * 29, misc={})
    assert "ignore_collisions" not in vars(plain) and plain.ignore_collisions is None
    assert "ignore_collisions" not in vars(Observation(**vars(plain)))
    plain.ignore_collisions = True
    assert Observation(**vars(plain)).ignore_collisions is True
