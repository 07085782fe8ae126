"""Arrays of things, one for each of `poses`: written out only as far as needed."""

from __future__ import annotations

import pytest

from tests.builder.document.conftest import Opener


def test_a_pose_changes_within_the_array(opened: Opener) -> None:
    """One element of the list, and nothing else."""
    document = opened("setup_checkers")
    before = document.scene_text
    document.set("piece5", "pose", [-0.12, -0.023, 0.021, 0.0, 0.0, 0.0, 1.0])
    assert document.scene_text == before.replace("[-0.115, -0.023, 0.021]", "[-0.12, -0.023, 0.021]")
    document.set("piece5", "pose", [-0.115, -0.023, 0.021, 1.0, 0.0, 0.0, 0.0])
    assert "[-0.115, -0.023, 0.021, 1.0, 0.0, 0.0, 0.0]" in document.scene_text


@pytest.mark.parametrize(("name", "entries"), [("piece0", 2), ("piece1", 3), ("piece5", 3), ("piece11", 2)])
def test_another_key_splits_the_array(opened: Opener, name: str, entries: int) -> None:
    """What is before and behind stays an array; all things are as they were, but for the one."""
    document = opened("setup_checkers")
    before, text = document.spec, document.scene_text
    document.set(name, "color", [1.0, 0.0, 0.0])
    assert before is not None and document.spec is not None
    assert document.scene_text.count("[[body]]") == text.count("[[body]]") - 1 + entries
    for old, new in zip(before.body, document.spec.body, strict=True):
        assert new == (old.model_copy(update={"color": (1.0, 0.0, 0.0)}) if old.name == name else old)
    assert document.scene_text.count("# to piece11, one for each pose") == 1


@pytest.mark.parametrize("name", ["piece0", "piece5", "piece10", "piece11"])
def test_one_of_an_array_is_deleted_or_renamed(opened: Opener, name: str) -> None:
    """The others keep names and places."""
    document = opened("setup_checkers")
    before = document.spec
    assert before is not None
    document.rename(name, "king")
    assert document.spec is not None
    assert [body.name for body in document.spec.body] == [("king" if b.name == name else b.name) for b in before.body]
    document.undo()
    document.delete(name, with_dependants=True)
    assert document.spec is not None
    assert list(document.spec.body) == [body for body in before.body if body.name != name]


def test_a_duplicate_counts_on(opened: Opener) -> None:
    """A numbered thing gets the next number that is free, and its own entry."""
    document = opened("setup_checkers")
    assert document.duplicate("piece3") == "piece24"
    assert document.spec is not None and document.spec.body[-1].pose == document.spec.body[4].pose


def test_an_array_with_angles_keeps_them(opened: Opener) -> None:
    """A pose without another rotation changes in place; one that is turned gets an entry of its own."""
    document = opened("setup_checkers")
    document.set_scene_text(
        'format = 2\n\n[[frame]]\nname = "a1"\nposes = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]]\nrpy = [3.1415927, 0.0, 0.0]\n'
    )
    document.set("a2", "pose", [0.0, 0.1, 0.2, 1.0, 0.0, 0.0, 0.0])
    assert "poses = [[0.0, 0.0, 0.1], [0.0, 0.1, 0.2]]\n" in document.scene_text
    document.set("a1", "pose", [0.0, 0.0, 0.1])
    assert document.scene_text.startswith(
        'format = 2\n\n[[frame]]\nname = "a1"\npose = [0.0, 0.0, 0.1]\n\n[[frame]]\nname = "a2"\n'
    )
