"""The English of the library: every sentence of every variation, read by the rules of `sentences.py`."""

from __future__ import annotations

from itertools import combinations

import pytest
from write_instructions import PAGE, page

from rlbench_pin.tasks import task_names
from tests.tasks.running import begin, running
from tests.tasks.sentences import alike, faults, first_verb, likeness

REPEATS = {"push_buttons"}
"""Tasks whose specification gives several variations the same goal."""


LEAST = {"training": 7, "held_out": 3, "vague": 1, "specific": 1}
"""Sentences of each kind at least."""


@pytest.fixture(scope="module", params=task_names())
def instructions(request: pytest.FixtureRequest) -> dict[int, dict[str, tuple[str, ...]]]:
    """Variation -> sentences of one task by kind; its world is built once. No variation begins with success."""
    with running(request.param) as task:
        clean, found = task.world.save(), {}
        for variation in range(task.variation_count()):
            task.world.restore(clean)
            returned = begin(task, variation, seed=variation)
            found[variation] = {kind: task.get_wording(kind) for kind in LEAST}
            assert tuple(returned) == found[variation]["training"]
            assert task.success() == (False, False)
    return found


@pytest.mark.simulation
def test_every_variation_has_sentences_of_its_own(
    instructions: dict[int, dict[str, tuple[str, ...]]], request: pytest.FixtureRequest
) -> None:
    """Ten and more, of every kind; no two variations share one, unless they share their goals."""
    assert all(len(kinds[kind]) >= least for kinds in instructions.values() for kind, least in LEAST.items())
    every = [sentence for kinds in instructions.values() for sentences in kinds.values() for sentence in sentences]
    assert len(set(every)) == len(every) or request.node.callspec.params["instructions"] in REPEATS


@pytest.mark.simulation
def test_articles_numbers_and_signs_are_right_in_every_variation(instructions: dict[int, dict[str, tuple[str, ...]]]) -> None:
    """`an` before vowels that are spoken, plurals behind numbers, a capital, a full stop, single spaces."""
    every = {s for kinds in instructions.values() for sentences in kinds.values() for s in sentences}
    assert {s: faults(s) for s in sorted(every) if faults(s)} == {}


@pytest.mark.simulation
def test_the_sentences_of_a_variation_differ_in_verb_and_structure(
    instructions: dict[int, dict[str, tuple[str, ...]]],
) -> None:
    """The first three in verb and opening; all others share at most three quarters of their words in common order."""
    kinds = instructions[0]
    every = [sentence for sentences in kinds.values() for sentence in sentences]
    assert alike(kinds["training"][:3]) == []
    assert [pair for pair in combinations(every, 2) if likeness(*pair) > 0.75] == []


@pytest.mark.simulation
def test_the_page_of_all_sentences_is_up_to_date() -> None:
    """As `python scripts/write_instructions.py` writes it."""
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python scripts/write_instructions.py`"


@pytest.mark.parametrize(
    ("sentence", "fault"),
    [
        ("Make a orange tower.", "article: a orange"),
        ("Hit the button that has a azure base.", "article: a azure"),
        ("Take an unique cup.", "article: an unique"),
        ("Fill an European cup.", "article: an european"),
        ("Wait a hour.", "article: a hour"),
        ("Put an 3 there.", "article: an 3"),
        ("Pile 1 blocks.", "number: 1 blocks"),
        ("Pile one red blocks.", "number: one red blocks"),
        ("Pile two red block on the square.", "number: two red block on"),
        ("Pile 3 things and 4 gizmos.", "number: 4 gizmos"),
        ("The crackers goes on the shelf.", "agreement: crackers goes"),
        ("lift it.", "no capital"),
        ("Lift it", "no full stop"),
        ("Lift it!", "no full stop"),
        ("Lift it .", "no full stop"),
        ("Lift  it.", "spacing"),
        ("Lift it , then go.", "spacing"),
        ("Lift it,then go.", "spacing"),
        ("Lift the {name} cup.", "spacing"),
    ],
)
def test_faults_are_found(sentence: str, fault: str) -> None:
    """Each kind in a sentence that has it."""
    assert fault in faults(sentence)


@pytest.mark.parametrize(
    "sentence",
    [
        "Make an orange tower and an unimportant one.",
        "Wear a uniform for an hour at a university, a unit of a European one.",
        "Is one of the blocks an 8? Take one block, or two of them.",
        "This is his glass: it has two holes, both 90 degrees apart.",
        "Pile blocks one over another until it carries four.",
    ],
)
def test_sound_sentences_have_no_faults(sentence: str) -> None:
    """Exceptions of the rules."""
    assert faults(sentence) == []


def test_sentences_that_are_much_alike_are_found() -> None:
    """By verb, by opening, by common words, and where all open with the verb; a sentence without a known verb is one, too."""
    assert first_verb("Over the cup, empty the other one.") == "empty"
    cup, shelf = "Lift the red cup.", "On the shelf there is a cup to take."
    assert alike([cup, shelf, "From the table into the box, drop whatever is made of clay."]) == []
    assert alike([cup, "From where it is, lift up whatever you see."])[0].startswith("opening")
    assert alike([cup, "Raise the red cup.", shelf])[0].startswith("words")
    assert alike([cup, "Empty all boxes here."])[0].startswith("all or none open with a verb")
    assert alike([cup, "Gyre and gimble."])[0].startswith("verb")
