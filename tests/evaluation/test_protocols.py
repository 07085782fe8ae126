"""Protocols: the published ones are complete, wrong ones are refused, and what they fix cannot be changed."""

from __future__ import annotations

import importlib.util
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
import write_protocol_results

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaPlanning,
    JointPosition,
    MoveArmThenGripper,
    low_dim_config,
    make_environment,
)
from rlbench_pin.environment.episode import EVALUATION_SEEDS
from rlbench_pin.environment.factors import factor_catalogue
from rlbench_pin.errors import InvalidValue, UnknownName
from rlbench_pin.evaluation import (
    EpisodeRecord,
    EvaluationConfig,
    PolicySettings,
    Protocol,
    ProtocolConflict,
    ProtocolFileError,
    ProtocolTasksMissing,
    Results,
    evaluation_seed,
    load_protocol,
    plan_episodes,
    protocol_names,
    task_set,
    write_results,
)
from rlbench_pin.evaluation.protocols.plan import check_policy, split_places
from rlbench_pin.recording import RecordConfig
from rlbench_pin.recording.config import item_seed, plan_items
from rlbench_pin.tasks import usable_task_names
from tests.evaluation.protocols_for_tests import small_file

LEVELS = {"L1": 31, "L2": 28, "L3": 21, "L4": 12}


def variations(protocol: Protocol) -> int:
    """Return the number of variations of the tasks of a protocol."""
    return sum(len(task.variations) for task in protocol.selected)


def test_the_published_protocols_are_complete() -> None:
    """Tasks, variations and episodes as published; tasks of sets as in the sets."""
    assert protocol_names() == ("agnostos", "colosseum", "fs10", "fs25", "fs50", "fs95", "gembench", "peract18")
    peract = load_protocol("peract18")
    assert (len(peract.task_names), variations(peract), peract.episodes) == (18, 249, 450)
    assert set(peract.task_names) == set(task_set("PERACT18").tasks)
    assert [task.title for task in peract.tasks] == sorted(task.title for task in peract.tasks)
    assert (peract.split("train").episodes, peract.split("validation").episodes) == (100, 25)
    gembench = load_protocol("gembench")
    assert {part: variations(gembench.of_part(part)) for part in gembench.parts} == LEVELS
    assert (len(gembench.task_names), gembench.episodes) == (44, 9200)
    colosseum = load_protocol("colosseum")
    ranges = {f"{name}:colosseum" for name, factor in factor_catalogue().items() if factor.colosseum is not None}
    assert (len(colosseum.task_names), len(colosseum.factors), set(colosseum.factors)) == (20, 15, ranges)
    assert {name for factor in factor_catalogue().values() for name in factor.by_task} <= set(colosseum.task_names)
    agnostos = load_protocol("agnostos")
    for name in ("agnostos", "fs10", "fs25", "fs50", "fs95"):
        protocol, contents = load_protocol(name), task_set("AGNOSTOS41" if name == "agnostos" else f"{name.upper()}_V1")
        assert {part: protocol.of_part(part).task_names for part in protocol.parts} == contents.parts
    assert agnostos.split("test").seeds == (0, 99)


def test_tasks_of_protocols_exist() -> None:
    """All of them."""
    names = {name for protocol in protocol_names() for name in load_protocol(protocol).task_names}
    assert names <= set(usable_task_names())
    for name in protocol_names():
        load_protocol(name).check_tasks_exist()


def test_variations_of_protocols_exist() -> None:
    """PerAct-18, AGNOSTOS and the few-shot sets have all variations of their tasks, GemBench names some that exist."""
    with make_environment(low_dim_config()) as environment:
        names = {n for p in protocol_names() for n in load_protocol(p).task_names}
        counts = {name: environment.get_task(name).variation_count() for name in names}
    for protocol in map(load_protocol, protocol_names()):
        for task in protocol.tasks:
            if protocol.name != "gembench":
                assert task.variations == tuple(range(counts[task.name])), (protocol.name, task.name)
            else:
                assert max(task.variations) < counts[task.name], task.name


@pytest.mark.parametrize(
    ("name", "error", "said"),
    [
        ("peract8", UnknownName, "Did you mean 'peract18'?"),
        ("gembench:L5", UnknownName, "Known: L1, L2, L3, L4"),
        ("peract18:L1", UnknownName, "part of the protocol 'peract18'"),
        ("none/such.toml", ProtocolFileError, "there is no such file"),
        (18, InvalidValue, "has to be a text"),
    ],
)
def test_unknown_protocols(name: str, error: type[Exception], said: str) -> None:
    """The error names what was possible."""
    with pytest.raises(error, match=said):
        load_protocol(name)


@pytest.mark.parametrize("part", ["", ":hard"])
def test_missing_tasks(tmp_path: Path, part: str) -> None:
    """A part with missing tasks is not evaluated; the error names them and the parts that are complete."""
    path = small_file(tmp_path, ("push_button", "push_a_bell"))
    with pytest.raises(ProtocolTasksMissing, match="push_a_bell.*Use a complete part: small:easy") as caught:
        EvaluationConfig.of_protocol("noop", load_protocol(f"{path}{part}"))
    assert caught.value.complete == ("small:easy",)
    assert caught.value.missing == ("push_a_bell",)


def test_an_unknown_task_in_an_own_file(tmp_path: Path) -> None:
    """The error proposes the nearest name."""
    path = small_file(tmp_path, ("reach_target", "reach_targt"))
    with pytest.raises(ProtocolTasksMissing, match=r"reach_targt \(did you mean reach_target\?\)"):
        EvaluationConfig.of_protocol("noop", load_protocol(path))


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("max_steps", "max_step", "Did you mean 'max_steps'?"),
        ("version = 1\n", "", "lacks version"),
        ('"wrist"', '"wrst"', "No camera is called 'wrst'. Did you mean 'wrist'?"),
        ("[4, 9]", "[4, 4]", "list of different numbers"),
        ("seeds = [0, 10]", "seeds = [0, 1]", "the same episodes twice"),
        ("splits.train", "splits.training", "Did you mean 'train'?"),
        ('"task"\n', '"tasks"\n', "Did you mean 'task'?"),
        ("push_button", "reach_target", "twice"),
        ("[64, 64]", "[64, 0]", "image_size"),
        ("version = 1", "version = ", "Invalid value"),
    ],
)
def test_wrong_own_files(tmp_path: Path, before: str, after: str, said: str) -> None:
    """The error names the file, the key, the value and what was possible."""
    changes = [(before, after)] if before != "push_button" else [(before, after), ("[4, 9]", "[1]")]
    path = small_file(tmp_path, *changes)
    with pytest.raises(ProtocolFileError) as caught:
        load_protocol(path)
    assert path in str(caught.value)
    assert said in str(caught.value)


def test_an_unknown_action_mode_in_an_own_file(tmp_path: Path) -> None:
    """It is found before the first episode."""
    path = small_file(tmp_path, ("EndEffectorPoseViaPlanning", "EndEffectorPoseViaPlaning"))
    with pytest.raises(UnknownName, match="Did you mean 'EndEffectorPoseViaPlanning'?"):
        EvaluationConfig.of_protocol("noop", load_protocol(path))


def test_the_hash_is_of_the_content(tmp_path: Path) -> None:
    """Comments do not count, every value does; the record of a results file gives the protocol back."""
    first = load_protocol(small_file(tmp_path))
    assert load_protocol(small_file(tmp_path, ("max_steps = 5", "max_steps = 5  # actions"))).sha256 == first.sha256
    assert load_protocol(small_file(tmp_path, ("max_steps = 5", "max_steps = 6"))).sha256 != first.sha256
    easy = first.of_part("easy")
    assert easy.sha256 == first.sha256
    assert Protocol.from_record(easy.record()) == easy
    with pytest.raises(InvalidValue, match="contradicts its content"):
        Protocol.from_record({**easy.record(), "version": 2})


def test_a_protocol_with_factors(tmp_path: Path) -> None:
    """Its episodes are also played with each setting, and no other setting is accepted; without, any is."""
    settings = ("friction:1", "combined:2")
    path = small_file(tmp_path, ('episodes_of = "task"', f'episodes_of = "task"\nfactors = {list(settings)}'))
    config = EvaluationConfig.of_protocol("noop", load_protocol(path))
    assert config.factors == settings
    assert {item.factors for item in plan_episodes(config)} == {"", *settings}
    assert Protocol.from_record(load_protocol(path).record()) == load_protocol(path)
    with pytest.raises(ProtocolConflict, match="--factors"):
        replace(config, factors=("mass:1",))
    plain = EvaluationConfig.of_protocol("noop", load_protocol(small_file(tmp_path)))
    assert replace(plain, factors=("mass:1",)).factors == ("mass:1",)


@pytest.mark.parametrize(
    ("name", "value"),
    [("max_steps", 6), ("max_seconds", 21.0), ("seed", 1), ("episodes", 3), ("variations", 1), ("tell_task", True),
     ("robot", "ur5e"), ("tasks", ("reach_target",))],
)  # fmt: skip
def test_settings_that_contradict(tmp_path: Path, name: str, value: object) -> None:
    """The error shows the flag, its value and that of the protocol."""
    config = EvaluationConfig.of_protocol("noop", load_protocol(small_file(tmp_path)))
    with pytest.raises(ProtocolConflict, match="contradicts the protocol 'small', which has `--"):
        replace(config, **{name: value})
    assert replace(config, time_limit=5.0).time_limit == 5.0


def test_what_policies_ask_for(tmp_path: Path) -> None:
    """The action mode of the protocol, its cameras or fewer, its image size; `noop`, `random` and `expert` are free."""
    protocol = load_protocol(small_file(tmp_path))
    poses, joints = (MoveArmThenGripper(arm, Discrete()) for arm in (EndEffectorPoseViaPlanning(), JointPosition()))

    def seen(camera: str, size: tuple[int, int]) -> dict[str, object]:
        return {"cameras": {camera: {"rgb": True, "image_size": size}}}

    check_policy(protocol, "mine.py:make", PolicySettings.of(poses, seen("wrist", (64, 64))))
    check_policy(protocol, "mine.py:make", PolicySettings.of(poses, {}))
    for policy in ("noop", "random", "expert"):
        check_policy(protocol, policy, PolicySettings.of(joints, {}))
    for mode, asked, said in (
        (joints, seen("wrist", (64, 64)), "`arm action mode JointPosition` .* `arm action mode EndEffectorPoseViaPlanning`"),
        (poses, seen("overhead", (64, 64)), "`cameras overhead` .* `cameras front wrist`"),
        (poses, seen("wrist", (128, 128)), "`image size of wrist .px. 128 128` .* 64 64"),
    ):
        with pytest.raises(ProtocolConflict, match=said):
            check_policy(protocol, "mine.py:make", PolicySettings.of(mode, asked))


def test_splits_are_disjoint() -> None:
    """Train and validation have seeds of recordings, below those of evaluations, and none in common."""
    protocol = load_protocol("peract18")
    for task in ("close_jar", "turn_tap"):
        seeds = {}
        for split in ("train", "validation"):
            indices: Counter[int] = Counter()
            seeds[split] = set()
            for variation, seed, _ in split_places(protocol, split)[task]:
                seeds[split].add(item_seed(seed, task, variation, indices[variation]))
                indices[variation] += 1
        assert not seeds["train"] & seeds["validation"]
        assert len(seeds["train"]) == 100
        assert max(seeds["train"] | seeds["validation"]) < EVALUATION_SEEDS
        assert all(evaluation_seed(seed, n) >= EVALUATION_SEEDS for _, seed, n in split_places(protocol, "test")[task])


def test_the_training_split_of_one_part() -> None:
    """GemBench is trained on level 1, whose split is that of the whole protocol; another level has none."""
    gembench = load_protocol("gembench")
    places = split_places(gembench, "train")
    assert places == split_places(gembench.of_part("L1"), "train")
    assert {v for v, _, _ in places["push_button"]} == {0, 3, 4}
    assert sum(map(len, places.values())) == 3100
    with pytest.raises(ProtocolConflict, match="gembench:L1"):
        split_places(gembench.of_part("L2"), "train")
    with pytest.raises(UnknownName, match="validation"):
        split_places(gembench, "validation")


def test_episodes_of_protocols(tmp_path: Path) -> None:
    """Repetitions have seeds of their own; episodes per variation are counted for each."""
    items = plan_episodes(EvaluationConfig.of_protocol("noop", load_protocol(small_file(tmp_path))))
    assert [(i.name, i.variation, i.seed) for i in items if i.name == "push_button"] == [
        ("push_button", v, evaluation_seed(*at)) for v, at in ((4, (0, 0)), (9, (0, 1)), (4, (10, 0)), (9, (10, 1)))
    ]
    each = load_protocol(small_file(tmp_path, ('"task"\n', '"variation"\n'))).of_part("hard")
    items = plan_episodes(EvaluationConfig.of_protocol("noop", each))
    assert [i.variation for i in items] == [4, 4, 9, 9] * 2
    assert len({i.policy_seed for i in items}) == 8
    beyond = load_protocol(small_file(tmp_path, ("[4, 9]", "[4, 99]")))
    with pytest.raises(InvalidValue, match="variations of 'push_button' in the protocol has? ?.*below 18"):
        plan_episodes(EvaluationConfig.of_protocol("noop", beyond))


def test_the_training_data_of_peract18_are_those_of_a_plain_recording() -> None:
    """Seed, variation and number of each of the 100 episodes of a task."""
    protocol = load_protocol("peract18")
    listed = {}
    for task, places in split_places(protocol, "train").items():
        counted: Counter[int] = Counter()
        episodes = []
        for variation, seed, _ in places:
            episodes.append((variation, item_seed(seed, task, variation, counted[variation])))
            counted[variation] += 1
        listed[task] = tuple(episodes)
    tasks = ("close_jar", "turn_tap")
    plain = plan_items(RecordConfig(tasks=tasks, episodes=100))
    assert plan_items(RecordConfig(tasks=tasks, listed={task: listed[task] for task in tasks})) == plain


def protocol_states() -> object:
    """Return the script that hashes initial states."""
    path = Path(__file__).resolve().parents[2] / "scripts" / "write_protocol_states.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_initial_states_are_those_of_the_file() -> None:
    """The test episodes of three tasks begin in the states whose hash the protocol publishes."""
    tasks = ("open_drawer", "slide_block_to_color_target", "turn_tap")
    published = load_protocol("peract18").initial_states
    assert protocol_states().digests("peract18", tasks) == {task: published[task] for task in tasks}  # type: ignore[attr-defined]
    assert set(published) == set(load_protocol("peract18").task_names)


def test_the_page_of_results_is_that_of_its_data() -> None:
    """As `write_protocol_results.py` writes it: the expert reaches 98 % on each level, the no-op policy nothing."""
    entries = write_protocol_results.stored()
    assert write_protocol_results.PAGE.read_text(encoding="utf-8") == write_protocol_results.page(entries)
    means = {(entry["name"], entry["policy"]): [mean["success"] for mean in entry["means"]] for entry in entries}
    for name in ("gembench", "peract18"):
        assert min(means[name, "expert"]) >= 0.98 and max(means[name, "noop"]) == 0.0


def test_results_of_unlike_versions_of_a_task_are_not_on_one_page(tmp_path: Path) -> None:
    """The second policy is refused with the versions of both; results of one version go together."""
    protocol = load_protocol(small_file(tmp_path))
    places = [(task.name, variation) for task in protocol.tasks for variation in task.variations[:1]]
    episodes = tuple(
        EpisodeRecord(task, variation, evaluation_seed(seed, i), success=False, lasts=False, steps=1, seconds=1.0, end="steps")
        for task, variation in places
        for seed in protocol.split("test").seeds
        for i in range(2)
    )
    seeds = tuple(dict.fromkeys(episode.seed for episode in episodes))
    first = Results("one", {}, "small", protocol.task_names, seeds, {}, {}, "", episodes, "key", protocol)
    later = replace(first, policy="two", task_versions={"reach_target": 1, "push_button": 2})
    entries = write_protocol_results.with_file([], write_results(tmp_path / "a.json", first))
    same = write_results(tmp_path / "b.json", replace(first, policy="two"))
    assert [entry["policy"] for entry in write_protocol_results.with_file(entries, same)] == ["one", "two"]
    with pytest.raises(SystemExit, match="one has {} beyond version 1, two {'push_button': 2}"):
        write_protocol_results.with_file(entries, write_results(tmp_path / "c.json", later))
