"""Factors of generalisation: named, graded, the same from the same seed, and gone without a trace at level 0."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointPosition,
    MoveArmThenGripper,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench_pin.environment.factors import FactorNotApplicable, FactorSetting, expand_settings, factor_catalogue
from rlbench_pin.environment.factors.catalogue import COMBINED
from rlbench_pin.environment.factors.draw import FUNCTIONS, OTHER
from rlbench_pin.environment.other_bodies import with_models
from rlbench_pin.environment.presets import image_config
from rlbench_pin.environment.replay import replay_succeeds
from rlbench_pin.environment.runtime import follow
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import InvalidArgument, UnknownName
from rlbench_pin.observation import Observation
from rlbench_pin.planning.timing import retime
from rlbench_pin.robot.geometry import bounds, solid_geometry
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.spatial import TABLE_HEIGHT, pose_to_se3
from rlbench_pin.tasks import library_names, task_class, task_scene
from rlbench_pin.tasks.placement import footprint

APPEARANCE = tuple(name for name, factor in factor_catalogue().items() if factor.group == "appearance")
SENSORS = ("image_blur", "image_jpeg", "image_exposure", "dead_pixels")
SLIDE = "put_item_in_drawer"


def environment(**keys: object) -> Environment:
    """Return the front camera, small, and the low-dimensional data."""
    config = image_config((64, 64), ("front",), depth=True, mask=False)
    config.set_all_low_dim(True)
    return Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0, **keys)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def bin_task() -> Iterator[TaskEnvironment]:
    """A task with manipulated and receiving objects that it does not paint."""
    with environment() as env:
        yield env.get_task("put_rubbish_in_bin")


@pytest.fixture(scope="module")
def drawer() -> Iterator[TaskEnvironment]:
    """A task with joints and three variations."""
    with environment() as env:
        yield env.get_task("open_drawer")


def start(task: TaskEnvironment, factors: str | Mapping[str, object], seed: int = 3) -> Observation:
    """Return the first observation of an episode with factors."""
    task.set_factors(factors)  # type: ignore[arg-type]
    return task.reset(seed=seed, variation=0)[1]


def content(observation: Observation) -> dict[str, bytes | None]:
    """Return every array of an observation as bytes."""
    values = {name: getattr(observation, name) for name in vars(observation) if name != "misc"}
    return {name: None if value is None else np.asarray(value).tobytes() for name, value in values.items()}


# Names and levels ---------------------------------------------------------------------------------------------------


def test_each_factor_has_a_function_and_growing_levels() -> None:
    """The catalogue and the functions have the same names; a higher level reaches farther."""
    assert {*FUNCTIONS, OTHER, COMBINED} == set(factor_catalogue())
    for factor in factor_catalogue().values():
        assert 1 <= len(factor.levels) <= 3 and factor.changes.endswith(".")
        for numbers, more in zip(factor.levels, factor.levels[1:]):
            assert numbers.keys() == more.keys() and numbers != more


def test_settings_are_read_in_any_form_and_written_in_one() -> None:
    """Text, texts and tables; in the order of the catalogue; level 0 is nothing."""
    wanted = FactorSetting((("light_color", 2), ("friction", 1)))
    texts = ("friction:1+light_color:2", "light_color:2 + friction:1", ["friction:1", "light_color:2"])
    assert all(FactorSetting.of(given) == wanted for given in (*texts, {"friction": 1, "light_color": 2}))
    assert str(wanted) == "light_color:2+friction:1" and FactorSetting.of(str(wanted)) == wanted
    assert str(FactorSetting.of("friction:colosseum")) == "friction:colosseum"
    assert not FactorSetting.of("") and FactorSetting.of({"friction": 0}) == FactorSetting()


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ("frictoin:1", UnknownName, "friction"),
        ("friction:4", InvalidArgument, "1, 2, 3, colosseum"),
        ("shadow:colosseum", InvalidArgument, "1, 2, 3"),
        ("friction", InvalidArgument, "friction:1"),
        ("friction:1+friction:2", InvalidArgument, "twice"),
        ({"friction": 1.5}, InvalidArgument, "colosseum"),
        ({"friction": True}, InvalidArgument, "colosseum"),
        (3, InvalidArgument, "text"),
    ],
)
def test_bad_settings_are_refused(given: object, error: type[Exception], message: str) -> None:
    """With what was possible."""
    with pytest.raises(error, match=message):
        FactorSetting.of(given)  # type: ignore[arg-type]


def test_words_of_a_command_line_become_settings() -> None:
    """A factor without a level means all its levels, `all` every factor."""
    assert expand_settings(["friction", "mass:2+damping:1"]) == ("friction:1", "friction:2", "friction:3", "mass:2+damping:1")
    every = expand_settings(["all"], 2)
    assert len(every) == len(factor_catalogue()) and "mass:2" in every and "instruction_none:1" in every
    presets = expand_settings(["all"], "colosseum")
    assert "friction:colosseum" in presets and all(setting.endswith(":colosseum") for setting in presets)
    with pytest.raises(UnknownName, match="friction"):
        expand_settings(["fricton"])


# What they change ---------------------------------------------------------------------------------------------------


@pytest.mark.simulation
@pytest.mark.parametrize("name", [*APPEARANCE, *SENSORS])
def test_what_is_seen_changes_and_nothing_else(bin_task: TaskEnvironment, name: str) -> None:
    """At every level the image is another one; objects and arm are where they were."""
    plain = start(bin_task, "")
    images = [plain.front_rgb.tobytes()]
    for level in range(1, len(factor_catalogue()[name].levels) + 1):
        changed = start(bin_task, {name: level})
        images.append(changed.front_rgb.tobytes())
        np.testing.assert_array_equal(changed.task_low_dim_state, plain.task_low_dim_state)
        np.testing.assert_array_equal(changed.joint_positions, plain.joint_positions)
    assert len(set(images)) == len(images)


@pytest.mark.simulation
def test_level_0_is_as_without_factors_and_all_of_them_are_removed(bin_task: TaskEnvironment) -> None:
    """To the byte, also after an episode with all factors."""
    with environment() as env:
        without = content(env.get_task("put_rubbish_in_bin").reset(seed=3, variation=0)[1])
    every = {n: len(f.levels) for n, f in factor_catalogue().items() if not f.why_not(bin_task.task) and f.group != "language"}
    assert content(start(bin_task, every)) != without
    assert content(start(bin_task, dict.fromkeys(every, 0))) == without


@pytest.mark.simulation
def test_the_same_seed_gives_the_same_bytes_in_any_order(bin_task: TaskEnvironment) -> None:
    """Whatever came before, and however the factors are ordered."""
    names = ["light_color:2", "friction:3", "camera_pose:1", "depth_noise:2", "start_configuration:3", "dead_pixels:1"]
    first = content(start(bin_task, "+".join(names)))
    start(bin_task, "table_color:3", seed=8)
    assert content(start(bin_task, "+".join(reversed(names)))) == first
    assert content(start(bin_task, "+".join(names), seed=4)) != first


@pytest.mark.simulation
def test_physics_is_scaled_within_the_range(drawer: TaskEnvironment) -> None:
    """Mass, friction and damping of the chest, and the gains of the arm; all come back."""
    world = drawer.world
    chest, overrides = world.body("chest").model, world.dynamics_overrides
    link = chest.links["drawer_top_link"]

    def values(factors: str) -> tuple[float, float, float]:
        start(drawer, factors)
        return overrides.mass(chest, link), overrides.friction(chest, link), world.robot.position_gain

    before, after = values(""), values("mass:3+friction:3+damping:3+arm_gains:3")
    ratios = [new / old for new, old in zip(after, before)]
    assert 0.5 <= ratios[0] <= 2.0 and 0.3 <= ratios[1] <= 1.5 and 0.65 <= ratios[2] <= 1.5 and 1.0 not in ratios
    assert values("") == before


@pytest.mark.simulation
@pytest.mark.parametrize("name", factor_catalogue()["mass"].by_task)
def test_masses_of_colosseum_are_in_kg(name: str) -> None:
    """Within the published range, whatever the size of the object."""
    ranges = factor_catalogue()["mass"].by_task[name]
    with environment() as env:
        task = env.get_task(name)
        for factors in ("mass:colosseum", "mass:colosseum+object_size:colosseum"):
            start(task, factors)
            world = task.task.world
            for body, (low, high) in ranges.items():
                model = world.body(body).model
                mass = sum(world.dynamics_overrides.mass(model, link) for link in model.links.values())
                assert low <= mass <= high, body
                assert sum(world.snapshot().body(body).masses.values()) == pytest.approx(mass)  # the planner knows


@pytest.mark.simulation
def test_the_arm_starts_elsewhere_at_rest(drawer: TaskEnvironment) -> None:
    """Farther at a higher level, in the same direction; the objects stay."""
    home = start(drawer, "")
    starts = [start(drawer, {"start_configuration": level}).joint_positions for level in (1, 2, 3)]
    offsets = [np.asarray(q) - home.joint_positions for q in starts]
    sizes = [float(np.abs(offset).max()) for offset in offsets]
    assert 0.0 < sizes[0] < sizes[1] < sizes[2] <= 0.2 + 1e-9
    np.testing.assert_array_equal(np.sign(offsets[0]), np.sign(offsets[2]))
    moved = start(drawer, "start_configuration:3")
    np.testing.assert_array_equal(moved.task_low_dim_state, home.task_low_dim_state)
    assert np.abs(np.asarray(moved.joint_velocities)).max() < 1e-6


@pytest.mark.simulation
def test_the_arm_stands_elsewhere(drawer: TaskEnvironment) -> None:
    """Farther at a higher level; model and simulation agree, demonstrations succeed and replay, and the arm comes back."""
    home, runtime = start(drawer, ""), drawer.runtime
    own = runtime.model
    tips = []
    for level in (1, 2, 3):
        seen = start(drawer, {"arm_base": level})
        np.testing.assert_allclose(runtime.model.tip_pose(np.asarray(seen.joint_positions)), seen.gripper_pose, atol=1e-6)
        np.testing.assert_array_equal(seen.joint_positions, home.joint_positions)
        tips.append(np.asarray(seen.gripper_pose))
    moved = [np.linalg.norm(tip[:3] - np.asarray(home.gripper_pose)[:3]) for tip in tips]
    assert 0.0 < moved[0] < moved[1] < moved[2] < 0.15
    demo = drawer.try_demo(seed=3).demo
    assert demo is not None
    state = drawer.get_state()
    start(drawer, "")
    assert runtime.model is own
    np.testing.assert_array_equal(drawer.get_observation().gripper_pose, home.gripper_pose)
    drawer.reset_to_demo(demo)
    assert replay_succeeds(drawer, demo)
    np.testing.assert_allclose(drawer.set_state(state).gripper_pose, demo[-1].gripper_pose, atol=1e-6)


def sides(scene: SceneSpec, body: BodySpec) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of a body around its origin, in the axes of its parent."""
    parts = next(iter(solid_geometry(resolve_asset(scene, body.asset), body.scale).values()))
    turn = pose_to_se3((0.0, 0.0, 0.0, *body.pose[3:]))
    return bounds((shape, turn * place) for shape, place in parts)


def with_look_alikes() -> list[str]:
    """Return the tasks whose scenes name similar models."""
    return [name for name in library_names() if any(body.look_alikes for body in task_scene(task_class(name)).body)]


@pytest.mark.parametrize("name", with_look_alikes())
def test_similar_models_have_the_size_of_the_object(name: str) -> None:
    """Every side of their bounding box within 18 %, and they rest at the same height."""
    scene = task_scene(task_class(name))
    for body in (body for body in scene.body if body.look_alikes):
        for asset in body.look_alikes:
            (other,) = (b for b in with_models(scene, {body.name: asset}).body if b.name == body.name)
            own, new = sides(scene, body), sides(scene, other)
            np.testing.assert_allclose(np.ptp(new, axis=0), np.ptp(own, axis=0), rtol=0.18)
            assert other.pose[2] + new[0, 2] == pytest.approx(body.pose[2] + own[0, 2])


@pytest.mark.simulation
def test_objects_are_replaced_by_similar_ones() -> None:
    """Another model at the same place, which demonstrations grasp; without the factor the model of the scene file is back."""
    with environment() as env:
        task = env.get_task("pick_up_cup")
        first = start(task, "")
        place, height = task.world.body("cup").pose, task.world.body("cup").aabb_size()[2]
        demo = start(task, "object_model:1") and task.try_demo(seed=3, variation=0).demo
        assert demo is not None and task.runtime.models["cup"] in task_scene(task_class("pick_up_cup")).body[0].look_alikes
        start(task, "object_model:1")
        np.testing.assert_allclose(task.world.body("cup").pose, place, atol=2e-3)
        assert task.world.body("cup").aabb_size()[2] == pytest.approx(height, rel=0.1)
        assert content(start(task, "")) == content(first)
        task.reset_to_demo(demo)
        assert replay_succeeds(task, demo)
        with pytest.raises(FactorNotApplicable, match="names no similar models"):
            env.get_task("open_drawer").set_factors("object_model:1")


@pytest.mark.simulation
def test_objects_have_another_size(drawer: TaskEnvironment) -> None:
    """With all that is attached to them; demonstrations succeed and replay, and states can be restored."""
    start(drawer, "")
    plain = drawer.world

    def measures() -> tuple[np.ndarray, float, float]:
        """Return size of the chest, distance of its handle from it, and the most that a drawer opens."""
        world = drawer.world
        chest, handle = world.body("chest"), world.frame("waypoint1")
        away = float(np.linalg.norm(handle.pose[:3] - chest.position))
        return chest.aabb_size(), away, world.joint("chest/drawer_bottom").upper

    before = measures()
    demo = start(drawer, "object_size:3") and drawer.try_demo(seed=3, variation=0).demo
    assert demo is not None and drawer.world is not plain
    state, last = drawer.get_state(), drawer.get_observation()
    start(drawer, "object_size:3")
    (size,) = set(drawer.runtime.sizes.values())
    assert 0.8 <= size <= 1.2 and size != 1.0
    for old, new in zip(before, measures()):
        np.testing.assert_allclose(new, size * np.asarray(old), rtol=0.01)
    start(drawer, "object_size:3", seed=4)
    assert drawer.runtime.sizes != {"chest": size}
    assert content(without_forces(drawer.set_state(state))) == content(without_forces(last))
    drawer.reset_to_demo(demo)
    assert replay_succeeds(drawer, demo)
    start(drawer, "")
    for old, new in zip(before, measures()):
        np.testing.assert_array_equal(new, old)
    plain_state, first = drawer.get_state(), drawer.get_observation()
    start(drawer, "object_size:1", seed=6)
    assert content(without_forces(drawer.set_state(plain_state))) == content(without_forces(first))


@pytest.mark.simulation
def test_commands_arrive_later(drawer: TaskEnvironment) -> None:
    """The motion of the arm with a latency of two ticks is that without, two ticks later."""

    def moved(factors: str) -> list[float]:
        first = start(drawer, factors)
        action = np.append(np.asarray(first.joint_positions) + [0.05, 0, 0, 0, 0, 0, 0], 1.0)
        return [float(drawer.step(action)[0].joint_positions[0] - first.joint_positions[0]) for _ in range(6)]

    at_once, later = moved(""), moved("action_latency:2")
    assert at_once[0] > 0.01
    np.testing.assert_allclose(later[:2], 0.0, atol=1e-4)
    np.testing.assert_allclose(later[2:], at_once[:4], atol=2e-3)


@pytest.mark.simulation
def test_lost_commands_are_the_same_again_and_survive_a_saved_state(drawer: TaskEnvironment) -> None:
    """With losses and latency an episode can be saved in the middle, and goes on to the byte."""
    first = start(drawer, "action_loss:3+action_latency:1")
    rng = np.random.default_rng(0)
    actions = [np.append(np.asarray(first.joint_positions) + rng.uniform(-0.03, 0.03, 7), 1.0) for _ in range(12)]
    for action in actions[:6]:
        drawer.step(action)
    state = drawer.get_state()
    rest = [content(drawer.step(action)[0]) for action in actions[6:]]
    drawer.set_state(state)
    assert [content(drawer.step(action)[0]) for action in actions[6:]] == rest
    assert pickle.loads(pickle.dumps(state)).episode.factors == "action_latency:1+action_loss:3"


@pytest.mark.simulation
@pytest.mark.parametrize("factors", ["action_loss:3", "action_loss:3+action_latency:1"])
def test_planned_motions_repeat_lost_commands(drawer: TaskEnvironment, factors: str) -> None:
    """Every command of a trajectory arrives, in its order: the motors never skip one, also with latency."""
    start(drawer, factors, seed=4)
    runtime, delay = drawer.runtime, drawer.world.command_delay
    assert delay is not None
    q = runtime.robot.joint_positions
    goal = q + np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    trajectory = retime(np.stack([q, goal]), runtime.model.limits)
    sent: list[tuple[np.ndarray, bool]] = []
    arrived: list[np.ndarray] = []

    def on_tick(target: np.ndarray) -> None:
        sent.append((target, delay.lost))
        arrived.append(delay.state().arrived.target)

    follow(runtime, trajectory, on_tick=on_tick)
    assert 0 < sum(lost for _, lost in sent) < len(sent)
    for (target, lost), (following, _) in zip(sent, sent[1:]):
        assert not lost or np.array_equal(target, following)
    np.testing.assert_allclose(runtime.robot.joint_positions, goal, atol=2e-3)
    given = np.unique([target[0] for target, _ in sent])
    reached = np.searchsorted(given, [target[0] for target in arrived if target[0] in given])
    assert set(np.diff(reached)) == {0, 1} and len(given) - reached[-1] <= 4


@pytest.mark.simulation
def test_noise_of_depth_and_joints_is_drawn_anew(drawer: TaskEnvironment) -> None:
    """Two observations of one instant differ by noise of the size that the level says."""
    plain = start(drawer, "")
    noisy = start(drawer, "joint_noise:3+depth_noise:3")
    other = drawer.get_observation()
    errors = np.asarray(noisy.joint_positions) - plain.joint_positions
    assert 0.0 < np.abs(errors).max() < 0.06 and not np.array_equal(noisy.joint_positions, other.joint_positions)
    assert 0.0 < np.abs(noisy.front_depth - plain.front_depth).max() < 0.1
    np.testing.assert_array_equal(noisy.front_rgb, plain.front_rgb)


@pytest.mark.simulation
def test_distractors_stand_away_from_the_task(bin_task: TaskEnvironment) -> None:
    """More at a higher level, the first ones at the same places; at rest, and gone in the next episode."""
    plain = start(bin_task, "")
    places: list[list[np.ndarray]] = []
    for level in (1, 2, 3):
        seen = start(bin_task, {"distractors": level})
        world = bin_task.world
        objects = [body for name, body in world.bodies.items() if name.startswith("distractor_object")]
        places.append([body.position for body in objects])
        assert len(objects) == 2**level and max(np.abs(body.velocity).max() for body in objects) < 0.05
        own = [body for body in world.bodies.values() if body not in objects]
        near = min(np.linalg.norm(a.position[:2] - b.position[:2]) for a in objects for b in own)
        assert near > 0.05 and all(abs(body.position[2] - TABLE_HEIGHT) < 0.1 for body in objects)
        np.testing.assert_allclose(seen.task_low_dim_state, plain.task_low_dim_state, atol=1e-3)
    for fewer, more in zip(places, places[1:]):
        np.testing.assert_allclose(fewer, more[: len(fewer)], atol=1e-3)
    start(bin_task, "")
    assert not any(name.startswith("distractor_object") for name in bin_task.world.bodies)


@pytest.mark.simulation
def test_distractors_leave_space_for_large_held_objects() -> None:
    """A tray that hangs from the gripper at a waypoint touches none."""
    with environment() as env:
        task = env.get_task("take_tray_out_of_oven")
        for seed in range(5):
            start(task, {"distractors": 3}, seed)
            objects = [body for name, body in task.world.bodies.items() if name.startswith("distractor_object")]
            tips = [waypoint.pose[:2] for waypoint in task.task.get_waypoints()]
            side = float(np.ptp(task.world.body("tray").bounds(), axis=0)[:2].max())
            assert objects and min(np.abs(body.position[:2] - tip).max() for body in objects for tip in tips) > side - 0.05


@pytest.mark.simulation
def test_the_task_is_placed_in_one_half_of_the_table(bin_task: TaskEnvironment) -> None:
    """Left or right of the arm, and in both halves without the factor; a task that stays cannot take it."""

    def sides(factors: str) -> set[bool]:
        bin_task.set_factors(factors)
        found = set()
        for seed in range(8):
            bin_task.reset(seed=seed, variation=0)
            low, high = footprint(bin_task.world)
            middle = np.append((low + high) / 2.0, 0.0)
            found.add(bool(pose_to_se3(bin_task.world.root.pose).act(middle)[1] >= 0.0))
        return found

    assert sides("placement_left:1") == {True} and sides("placement_right:1") == {False} and sides("") == {True, False}
    with environment(factors="placement_left:1") as env, pytest.raises(FactorNotApplicable, match="same place"):
        env.get_task("reach_target")


# Language -----------------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_instructions_are_of_the_kind_asked_for(drawer: TaskEnvironment) -> None:
    """Held-out, vague, specific; those of another variation; none. The goal stays."""
    start(drawer, "")
    task, own = drawer.task, drawer.get_task_descriptions()
    for kind in ("held_out", "vague", "specific"):
        start(drawer, {f"instruction_{kind}": 1})
        assert sorted(drawer.get_task_descriptions()) == sorted(task.get_wording(kind))  # type: ignore[arg-type]
    plain = start(drawer, "")
    other = start(drawer, "instruction_other:1")
    said = drawer.get_task_descriptions()
    assert not set(own) & set(said) and ("middle" in said[0] or "top" in said[0])
    assert other.misc["descriptions"] == said and other.misc["variation_index"] == 0
    np.testing.assert_array_equal(other.task_low_dim_state, plain.task_low_dim_state)
    start(drawer, "instruction_none:1")
    assert drawer.get_task_descriptions() == [""]


# Refusals -----------------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_a_task_that_cannot_take_a_factor_says_why() -> None:
    """By its scene file, by its one variation, or because nothing has a joint."""
    with environment() as env:
        task = env.get_task("stack_cups")
        for setting, reason in (("object_color:1", "colours that have a meaning"), ("damping:1", "joint")):
            with pytest.raises(FactorNotApplicable, match=reason):
                task.set_factors(setting)
        task.set_factors("light_color:1")
        assert str(task.factors) == "light_color:1"
    with environment(factors="instruction_other:1") as env, pytest.raises(FactorNotApplicable, match="one variation"):
        env.get_task("put_rubbish_in_bin")


@pytest.mark.simulation
def test_factors_and_domain_randomization_exclude_each_other() -> None:
    """They change the same properties."""
    keys = {"randomize_every": RandomizeEvery.EPISODE, "visual_randomization_config": VisualRandomizationConfig()}
    with environment(**keys) as env:
        task = env.get_task("open_drawer")
        with pytest.raises(InvalidArgument, match="domain randomization"):
            task.set_factors("light_color:1")


# Demonstrations -----------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_a_demonstration_carries_its_factors_and_can_be_replayed(drawer: TaskEnvironment) -> None:
    """Another environment starts from it with the same factors, in the same state."""
    drawer.set_factors("friction:2+start_configuration:2+light_color:3")
    outcome = drawer.try_demo(seed=5, variation=1)
    assert outcome.demo is not None and outcome.demo.factors == "light_color:3+friction:2+start_configuration:2"
    with environment() as env:
        task = env.get_task("open_drawer")
        _, seen = task.reset_to_demo(outcome.demo)
        assert str(task.factors) == outcome.demo.factors
        assert content(without_misc(seen)) == content(without_misc(outcome.demo[0]))


def without_forces(observation: Observation) -> Observation:
    """Return an observation without the forces of the last tick, which a restored state does not have."""
    return replace(observation, joint_forces=None)


def without_misc(observation: Observation) -> Observation:
    """Return an observation without what demonstrations add."""
    kept = replace(observation, misc={})
    kept.ignore_collisions = None
    return kept
