"""A thing that is hung on another stays where it is in the world, to 1e-9, in one edit."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.builder.document import EditRefused
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import compose, inverse
from rlbench_pin.viewer.places import places_at_rest
from tests.builder.document.conftest import Opener


@pytest.mark.parametrize("task", ["pick_and_lift", "setup_checkers", "open_drawer", "stack_blocks"])
def test_the_place_in_the_world_is_kept(opened: Opener, task: str) -> None:
    """Whatever is hung on whatever, however it is turned; undone, the bytes are those of before."""
    document, rng = opened(task), np.random.default_rng(3)
    turned = np.concatenate([rng.uniform(-0.2, 0.2, 3), rng.normal(size=4)])
    turned[3:] /= np.linalg.norm(turned[3:])
    assert document.spec is not None
    document.set(document.spec.body[-1].name, "pose", turned)
    hung = 0
    for name in [thing.name for thing in document.spec.posed()]:
        for parent in ["root", *(body.name for body in document.spec.body)]:
            before, text = places_at_rest(document.spec), document.text
            here, frame = before.of(name), before.of(parent)
            assert here is not None and frame is not None
            try:
                document.attach(name, parent, compose(inverse(frame), here))
            except RlbenchPinError:  # it hangs on itself
                assert document.text == text
                continue
            after = places_at_rest(document.spec).of(name)
            assert after is not None
            turn = min(np.abs(after[3:] - here[3:]).max(), np.abs(after[3:] + here[3:]).max())
            assert np.abs(after[:3] - here[:3]).max() < 1e-9 and turn < 1e-9
            assert next(t for t in document.spec.posed() if t.name == name).parent == parent
            if document.text != text:
                hung += 1
                document.undo()
            assert document.text == text
    assert hung > 5


def test_what_cannot_hang_is_refused(opened: Opener) -> None:
    """On itself, on what hangs on it, on nothing that there is; joints hang on nothing."""
    document = opened("open_drawer")
    text = document.text
    for name, parent in (("chest", "chest"), ("chest", "handle_top"), ("waypoint0", "nowhere")):
        with pytest.raises(RlbenchPinError, match=parent):
            document.attach(name, parent, [0.0, 0.0, 0.0])
    with pytest.raises(EditRefused, match="no pose"):
        document.attach("chest/drawer_top", "root", [0.0, 0.0, 0.0])
    assert document.text == text


def test_short_numbers_stay_short(opened: Opener) -> None:
    """Digits that say nothing are not written."""
    document = opened("pick_and_lift")
    document.attach("block", "marker", [0.1, 0.2, -0.0225])
    assert 'parent = "marker"\npose = [0.1, 0.2, -0.0225]\n' in document.scene_text
    document.attach("block", "root", [0.0, 0.0, 0.0])
    assert document.scene_text.count('parent = "marker"') == 2
