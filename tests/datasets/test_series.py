"""Values that look alike come back as what they were, also when they follow each other."""

from __future__ import annotations

from pathlib import Path

import h5py

from rlbench_pin.datasets.series import read_series, write_series


def test_equal_values_of_other_types_stay_apart(tmp_path: Path) -> None:
    """1, True and 1.0, keys 1 and '1', 0.0 and -0.0, dicts in another order, lists and tuples: each as it was written."""
    values = [1, True, True, {1: "a"}, {1: "a"}, {"1": "a"}, {True: "a"}, {"a": 0.0}, {"a": -0.0}]
    values += [{"a": 1, "b": None}, {"b": None, "a": 1}, [1, 2], (1, 2), [1, [2, 3]], [1, [2, 3]], [1, [2, 4]], "text", "text"]
    with h5py.File(tmp_path / "series.h5", "w") as file:
        write_series(file, "values", values, "gzip")
        read = read_series(file, "values", len(values))
    assert [repr(value) for value in read] == [repr(value) for value in values]
