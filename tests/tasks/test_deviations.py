"""Tasks are as their specification says, or a deviation is listed: in the scene file, and on the page made from it."""

from __future__ import annotations

import re

import numpy as np
import pytest
from write_deviations import PAGE, page

from rlbench_pin.tasks import library_names, task_class, task_scene
from tests.tasks.figures import Figure, measured, specification

SPECIFIED = specification()
SIZES = 2.5e-3
"""Solids with twelve corners and meshes with a skin of 1 mm may be so much smaller than what they stand for [m]."""
KINDS = "yaw|yaw that fits|variations|static|gripper|travel|distance apart|(free|spawned|graspable) bodies"
NAME = re.compile(rf"({KINDS}|(sensor|region|size|height|mass|joints|range|joint) \S+)")
"""How figures are called."""


def alike(name: str, a: Figure, b: Figure) -> bool:
    """Whether two values of a figure agree; boxes may lie along any axes."""
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    kind = name.split(" ")[0]
    if kind in ("sensor", "region", "size") and len(a) == 3:
        a, b = sorted(a), sorted(b)
    absolute = {"size": SIZES, "height": SIZES, "mass": 0.0}.get(kind, 0.5 if name == "yaw that fits" else 1e-3)
    return len(a) == len(b) and bool(np.allclose(a, b, atol=absolute, rtol=1e-6))


def in_text(name: str, text: str) -> Figure:
    """Return the value that a text says; what follows a colon explains it."""
    return text if name == "gripper" else [float(v) for v in re.findall(r"-?\d+(?:\.\d+)?", text.partition(":")[0])]


def test_the_page_is_what_the_scenes_say() -> None:
    """Written again, it stays as it is."""
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python scripts/write_deviations.py`"


@pytest.mark.parametrize("name", library_names())
def test_a_figure_is_as_specified_or_a_deviation_is_listed(name: str) -> None:
    """Both sides of a deviation are the figures of today, and no deviation is listed where there is none."""
    specified, here = SPECIFIED[name], measured(name)
    listed = {deviation.name: deviation for deviation in task_scene(task_class(name)).deviation}
    assert specified.keys() - here.keys() == set(), "figures of things that are not there"
    assert {key for key in listed if NAME.fullmatch(key)} - specified.keys() == set(), "deviations without a figure"
    for key, value in specified.items():
        if key not in listed:
            assert alike(key, here[key], value), f"{key} is {here[key]}, specified {value}: mend it or list a deviation"
            continue
        assert not alike(key, here[key], value), f"{key} is as specified: strike the deviation"
        assert alike(key, in_text(key, listed[key].specified), value), key
        assert alike(key, in_text(key, listed[key].here), here[key]), f"{key} is {here[key]}"


def test_every_task_has_its_figures() -> None:
    """A new task needs its own in `specification.toml`."""
    assert set(SPECIFIED) == set(library_names())
