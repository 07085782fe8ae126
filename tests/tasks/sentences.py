"""What is wrong with an English sentence, and how much two are alike; there is no dictionary, so both know only some words."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import SequenceMatcher
from itertools import combinations


def words(sentence: str) -> list[str]:
    """The words in lower case."""
    return re.findall(r"[\w'-]+", sentence.lower())


VERBS = frozenset(
    words(
        "belongs bin bring build carry choose clear click close complete connect dangle dispose drag draw drive drop "
        "empty fetch find finish fit flip fold get give go grip hang hit hold hook keep lay lead leave lift load lower "
        "make mount move nest nudge open operate park pick pile play pour press pull push put raise receive return rid "
        "rise rotate rub score set shoot shove slide slip sort sponge stack stick stretch surround sweep swing switch "
        "take thread throw tip touch transfer turn twist unhook unlatch unload unlock unscrew use water weigh wipe"
    )
)
"""What sentences ask for; a new one is added here."""
COUNTED = words(
    "ball bar block book brick bulb button centimetre chair compartment crumb cube cup degree door drawer end handle hole "
    "holder item jar knob layer level mug object other pepper piece pin place shape shoe side square step storey thing tomato"
)
"""Nouns that stand behind a number, in the singular."""
FUNCTION_WORDS = words("and are at by for from in into is lie lies of on onto over stand stands that to whose with")
"""They stand behind a number that has no noun."""
NUMBERS = words("two three four five six seven eight nine ten eleven twelve thirteen")
MAX_ALIKE = 0.5
"""Highest share of common words in common order of two sentences of one variation."""
_NOT_A_VOWEL = re.compile(r"uni(?![mn])|u[st][aeiu]|one\b|once\b|eu")
_WHERE_VERBS_STAND = re.compile(r"(?:^|[.,:;?] |\b(?:and|must|please|should|so|then|to) |(?= belongs))(?= ?(\w+))")
_A_VOWEL = re.compile(r"[aeiou]|hour|hono|honest|heir|8|11\b|18\b")


def faults(sentence: str) -> list[str]:
    """Say what is wrong with a sentence, or with several in a row."""
    found = []
    if not sentence[:1].isupper():
        found.append("no capital")
    if not re.search(r"\w\.$", sentence):
        found.append("no full stop")
    if re.search(r"\s\s|^\s|\s[,.;:?!]|[,.;:?!]{2}|[,;:?!.][^\W\d]|[{}]", sentence):
        found.append("spacing")
    found += [
        f"article: {a} {word}" for a, word in re.findall(r"\b(an?) ([\w'-]+)", sentence.lower()) if (a == "an") != _vowel(word)
    ]
    found += [
        f"agreement: {what}" for what in re.findall(r"\b\w+[^\Wsiu]s (?:is|goes|has|was|belongs|needs)\b", sentence.lower())
    ]
    return found + [f"number: {phrase}" for phrase in _numbered(sentence.lower()) if not _agrees(phrase)]


def first_verb(sentence: str) -> str:
    """The first verb that asks for something, empty without one: a known one where an imperative or an infinitive stands."""
    return next((word for word in _WHERE_VERBS_STAND.findall(sentence.lower()) if word in VERBS), "")


def alike(sentences: Sequence[str]) -> list[str]:
    """Say in what the sentences for one goal do not differ: verb, opening, order of the words, kind of opening."""
    found = [f"verb: {s}" for s in sentences if not first_verb(s)]
    for one, other in combinations(sentences, 2):
        if first_verb(one) == first_verb(other) or words(one)[0] == words(other)[0]:
            found.append(f"opening: {one} {other}")
        if likeness(one, other) > MAX_ALIKE:
            found.append(f"words: {one} {other}")
    if len({words(s)[0] == first_verb(s) for s in sentences}) < 2:
        found.append(f"all or none open with a verb: {sentences[0]}")
    return found


def likeness(one: str, other: str) -> float:
    """Return the share of common words in common order of two sentences."""
    return SequenceMatcher(None, words(one), words(other), autojunk=False).ratio()


def _vowel(word: str) -> bool:
    return bool(_A_VOWEL.match(word)) and not _NOT_A_VOWEL.match(word)


def _numbered(sentence: str) -> list[str]:
    """Each number with up to three words of the same clause behind it."""
    return re.findall(rf"\b(?=((?:\d+|one|{'|'.join(NUMBERS)})\b(?: [\w'-]+){{0,3}}))", sentence)


def _agrees(phrase: str) -> bool:
    """Whether the noun behind a number is singular behind one and plural behind others; a number without a noun agrees."""
    number, *behind = phrase.split()
    if not behind or behind[0] in FUNCTION_WORDS:
        return True
    single = number in ("1", "one")
    noun = next((word for word in behind if word.removesuffix("s") in COUNTED), None)
    return number == "one" if noun is None else (noun in COUNTED) == single
