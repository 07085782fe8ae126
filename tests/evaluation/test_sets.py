"""The sets hold what the public lists say, and nest as these do."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.errors import InvalidValue, TaskError, UnknownName
from rlbench_pin.evaluation.sets import (
    gembench_tasks,
    public_tasks,
    resolve_tasks,
    task_families,
    task_set,
    task_sets,
    task_tier,
    variant_tasks,
)
from rlbench_pin.tasks import LIBRARY, task_names

SPLITS = {"FS10_V1": (10, 5), "FS25_V1": (25, 5), "FS50_V1": (50, 5), "FS95_V1": (95, 5)}
SIZES = {
    "COLOSSEUM20": 20,
    "MT15_V1": 15,
    "MT30_V1": 30,
    "MT55_V1": 55,
    "MT100_V1": 100,
    "PERACT18": 18,
    "tier1": 11,
    "tier2": 29,
    "tier3": 25,
    "tier4": 41,
}
IN_NO_SET = {
    *("lift_numbered_block", "open_washing_machine", "pick_and_lift_small", "put_all_groceries_in_cupboard", "setup_chess"),
    "stack_chairs",
}


def test_the_public_set_has_106_tasks() -> None:
    """And the library has them, the variants, the tasks that GemBench adds, and nothing else."""
    assert len(set(public_tasks())) == 106 and list(public_tasks()) == sorted(public_tasks())
    assert not set(variant_tasks()) & set(public_tasks())
    assert {file.stem for file in LIBRARY.glob("*.toml")} == {*public_tasks(), *variant_tasks(), *gembench_tasks()}
    assert not set(gembench_tasks()) & {*public_tasks(), *variant_tasks()} and len(set(gembench_tasks())) == 17


def test_sizes() -> None:
    """Of every set and its parts; each task is in a set once, and known."""
    assert set(task_sets()) == {*SPLITS, *SIZES, "AGNOSTOS41", *task_families()}
    for name in {*SPLITS, *SIZES}:
        assert task_set(name).notes
    for name in task_sets():
        held = task_set(name)
        assert len(set(held.tasks)) == len(held.tasks)
        if name in SPLITS or name in SIZES:
            assert len(held.tasks) == (sum(SPLITS[name]) if name in SPLITS else SIZES[name])
        assert set(held.tasks) <= {*public_tasks(), *variant_tasks(), *gembench_tasks()}
        assert held.about
    for name, (train, test) in SPLITS.items():
        parts = task_set(name).parts
        assert (len(parts["train"]), len(parts["test"])) == (train, test)
        assert task_set(f"{name}:train").tasks + task_set(f"{name}:test").tasks == task_set(name).tasks


def test_agnostos_has_the_tasks_of_peract_and_23_others() -> None:
    """18 seen and 23 unseen."""
    assert task_set("AGNOSTOS41:seen").tasks == task_set("PERACT18").tasks
    assert len(task_set("AGNOSTOS41:unseen").tasks) == 23


def test_every_task_is_in_one_family() -> None:
    """Public tasks, variants, and those of GemBench."""
    grouped = [name for family in task_families() for name in task_set(family).tasks]
    assert sorted(grouped) == sorted((*public_tasks(), *variant_tasks(), *gembench_tasks()))


def test_sets_nest() -> None:
    """A larger few-shot set trains on all of the smaller one; the multi-task sets are these without a split."""
    for small, large in (("FS10_V1", "FS25_V1"), ("FS25_V1", "FS50_V1"), ("FS50_V1", "FS95_V1")):
        assert task_set(large).parts["train"][: len(task_set(small).tasks)] == task_set(small).tasks
    for few, many in (("FS10_V1", "MT15_V1"), ("FS25_V1", "MT30_V1"), ("FS50_V1", "MT55_V1"), ("FS95_V1", "MT100_V1")):
        assert task_set(few).tasks == task_set(many).tasks
    assert set(public_tasks()) - set(task_set("MT100_V1").tasks) == IN_NO_SET


def test_tiers_part_the_public_set() -> None:
    """Every public task has one tier, and no variant has any."""
    tiers = [task for tier in range(1, 5) for task in task_set(f"tier{tier}").tasks]
    assert sorted(tiers) == list(public_tasks())
    assert (task_tier("reach_target"), task_tier("open_drawer"), task_tier("wipe_desk")) == (1, 2, 4)
    with pytest.raises(UnknownName):
        task_tier("slide_block_to_color_target")


def test_peract_names_three_variants() -> None:
    """The rest of its 18 are public tasks."""
    variants = {"slide_block_to_color_target", "place_wine_at_rack_location", "sweep_to_dustpan_of_size"}
    assert set(task_set("PERACT18").tasks) - set(public_tasks()) == variants


@pytest.mark.parametrize(
    ("name", "near"), [("FS10", "FS10_V1"), ("tier5", "tier"), ("FS10_V1:tests", "FS10_V1:test"), ("MT15_V1:train", "")]
)
def test_a_wrong_name_proposes_the_nearest(name: str, near: str) -> None:
    """Of a set, or of one of its parts; a set without parts has none."""
    with pytest.raises(UnknownName, match=f"Did you mean '{near}" if near else "No set"):
        task_set(name)


def test_words_are_mixed() -> None:
    """Names, classes' names, files, sets and parts; each task once, in order."""
    file = str(LIBRARY / "reach_target.py")
    words = ["open_drawer", "ReachTarget", "FS10_V1:test", "open_box", file]
    assert list(resolve_tasks(words)) == ["open_drawer", "reach_target", *task_set("FS10_V1").parts["test"], file]
    assert set(resolve_tasks(["all"])) == set(task_names())
    assert resolve_tasks([]) == ()


def test_hostile_words(tmp_path: Path) -> None:
    """Unknown names propose the nearest task or set; files have to hold a task."""
    with pytest.raises(UnknownName, match="Did you mean 'reach_target'"):
        resolve_tasks(["reach_targt"])
    with pytest.raises(UnknownName, match="Did you mean 'MT15_V1'"):
        resolve_tasks(["MT15V1"])
    with pytest.raises(TaskError):
        resolve_tasks([str(tmp_path / "none.py")])
    wrong: list[object] = ["reach_target", [1], None, 3]
    for words in wrong:
        with pytest.raises(InvalidValue):
            resolve_tasks(words)  # type: ignore[arg-type]
