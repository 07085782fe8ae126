"""Instructions find their recipes, and the policy solves episodes from images."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("small_gicp")

from rlbench_pin.baselines.classical import TASKS, policy
from rlbench_pin.baselines.classical.recipes import (
    FRIDGE_BAR,
    HOOD_DOWN,
    HOOD_UP,
    MICROWAVE_BAR,
    RECIPES,
    Bar,
    Instruction,
    find_recipe,
)
from rlbench_pin.baselines.classical.skills import NothingFound
from rlbench_pin.environment import Environment
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext
from rlbench_pin.tasks import library_names

SENTENCES = {
    "press_buttons": ["Press the maroon button, then the green one.", "The teal button is the one that I want you to push."],
    "press_lamp_button": [
        "It is too dark in here, please turn on the light.",
        "The lamp does not shine yet, so click its button.",
    ],
    "flip_switch": ["It is dark in here, please turn on the light at the wall."],
    "reach_ball": ["Which ball is red? Touch it.", "With the fingertips, go to the sphere that is red."],
    "bin_paper": ["There is a ball of paper between the tomatoes, please put it in the bin."],
    "lift_block_to_ring": ["There is a ring in the air: hold the red block in it."],
    "shove_block": ["There is a green square on the table: nudge the red cube to its centre."],
    "lift_lid": ["The pan must cool down: hold its lid well above it by the knob."],
    "push_drawer": ["The chest looks untidy, so shove its bottom compartment back."],
    "meat_on_grill": ["To cook the steak, carry it from the table to the grill and leave it there."],
    "meat_off_grill": ["The chicken is done: take it off the barbecue and set it down along one of the longer sides."],
    "unplug": ["Draw the plug from the outlet until both of its prongs are free."],
    "pull_drawer": ["Of the three drawers in the chest, slide the top one far out."],
}


@pytest.mark.parametrize(("recipe", "sentence"), [(name, s) for name, sentences in SENTENCES.items() for s in sentences])
def test_a_sentence_finds_its_recipe(recipe: str, sentence: str) -> None:
    """No task name is needed."""
    assert find_recipe(Instruction.read(sentence)).__name__ == recipe


@pytest.mark.parametrize(
    ("bar", "sentence"),
    [
        (MICROWAVE_BAR, "Open the microwave oven almost to a right angle."),
        (FRIDGE_BAR, "I want to get at the shelves, please open the big door of the refrigerator."),
        (HOOD_UP, "I want to put meat on the grate, please open the grill."),
        (HOOD_DOWN, "The grill is open, please lower its lid."),
    ],
)
def test_a_sentence_finds_its_bar(bar: Bar, sentence: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Doors and hoods with a bar share one recipe, told which."""
    turned: list[object] = []
    monkeypatch.setattr("rlbench_pin.baselines.classical.recipes.turn_bar", lambda gripper, which: turned.append(which))
    find_recipe(Instruction.read(sentence))(None, Instruction(()))  # type: ignore[arg-type]
    assert turned == [bar]


def test_every_task_exists() -> None:
    """What scripts evaluate are tasks of the library, each once."""
    assert set(TASKS) <= set(library_names())
    assert len(set(TASKS)) == len(TASKS) >= 12


def test_what_is_not_known_is_said() -> None:
    """There is no recipe for everything, and no guess."""
    with pytest.raises(NothingFound, match="violin"):
        find_recipe(Instruction.read("Play the violin."))


def test_colours_come_in_the_order_of_the_sentence() -> None:
    """Each once, whatever the punctuation."""
    assert Instruction.read("Maroon is the first, green the second, blue the third; maroon!").colors == (
        "maroon",
        "green",
        "blue",
    )


def test_every_recipe_is_found_by_a_phrase_of_its_own() -> None:
    """No recipe is hidden behind one before it."""
    for recipe in RECIPES:
        words = " ".join([*recipe.objects.split("|")[:1], *recipe.asks.split("|")[:1]])
        assert recipe.fits(Instruction.read(words))


def test_it_is_a_policy_that_sees_no_state() -> None:
    """Colours, depth, the arm's own joints: no masks, no clouds, no state of the task."""
    classical = policy()
    assert isinstance(classical, Policy)
    config = classical.obs_config
    assert not config.task_low_dim_state
    assert all(not camera.mask and not camera.point_cloud for camera in config.cameras().values())


def _context() -> PolicyContext:
    return PolicyContext("panda", 7, (), (), 0.05, 300, 0)


@pytest.mark.simulation
@pytest.mark.parametrize("task", ["reach_target", "lamp_on", "take_lid_off_saucepan"])
def test_it_solves_an_episode(task: str) -> None:
    """Three tasks of different kinds, from the instruction and the images alone."""
    classical = policy()
    with Environment(classical.action_mode, obs_config=classical.obs_config) as environment:
        scene = environment.get_task(task)
        instructions, observation = scene.reset(seed=20001)
        classical.reset(instructions[1], _context())
        reward, ended, steps = 0.0, False, 0
        while not ended and steps < 300:
            action = classical.act(observation)
            assert action.shape == (8,) and np.isfinite(action).all()
            observation, reward, ended = scene.step(action)
            steps += 1
        assert reward == 1.0
