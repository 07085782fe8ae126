"""The factors of generalisation: names, levels, values, and the tasks to which each applies."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Literal

from rlbench_pin.errors import InvalidArgument, UnknownName
from rlbench_pin.scene.spec import InstructionsSpec
from rlbench_pin.tasks import Task
from rlbench_pin.values import as_text

Group = Literal["appearance", "sensors", "scene", "physics", "arm", "language"]
Level = int | Literal["colosseum"]
"""1, 2 or 3, or the ranges of COLOSSEUM."""
Numbers = Mapping[str, float | tuple[float, float]]
"""Values of one level: a range to draw from, or a value."""
COLOSSEUM: Literal["colosseum"] = "colosseum"
JOINED, LEVEL = "+", ":"
ALL = "all"
"""Name for all factors on a command line."""
COMBINED = "combined"
"""The factor that combines many others."""
_REASONS = {
    "manipulated": "its scene marks no object as manipulated",
    "receiving": "its scene marks no object as receiving",
    "look_alikes": "its scene names no similar models of its objects",
    "joints": "no object of its scene has a joint",
    "placement": "it always stands at the same place",
    "variations": "it has one variation",
    **{kind: f"its scene has no {kind.replace('_', '-')} instructions" for kind in InstructionsSpec.model_fields},
}
"""Need of a factor -> reason why the factor does not apply to a task without it."""


@dataclass(frozen=True)
class Factor:
    """One factor: a change of the environment between training and test that keeps the task."""

    name: str
    group: Group
    """Part of an episode that the factor changes."""
    changes: str
    """Description, as sentences."""
    levels: tuple[Numbers, ...]
    """Values of level 1, 2, ...; level 0 is no change."""
    colosseum: Numbers | None = None
    """Values of COLOSSEUM (arXiv 2402.08191); None if it has no such factor."""
    needs: str = ""
    """Elements that a task must have, such as `receiving` objects."""
    by_task: Mapping[str, Numbers] = field(default_factory=dict)
    """Values of COLOSSEUM for the tasks where they differ, by name of the task."""

    def numbers(self, level: Level) -> Numbers:
        """Return the values of a level.

        Raises:
            InvalidArgument: The factor has no such level.
        """
        if level == COLOSSEUM and self.colosseum is not None:
            return self.colosseum
        if level == COLOSSEUM or not 1 <= level <= len(self.levels):
            raise InvalidArgument(
                f"level of '{self.name}'", level, f"has to be one of {', '.join(self.level_names)}, or 0 for none"
            )
        return self.levels[level - 1]

    def numbers_for(self, level: Level, task: Task) -> Numbers:
        """Return the values of a level for one task, which may have its own ranges.

        Raises:
            InvalidArgument: The factor has no such level.
        """
        numbers = self.numbers(level)
        if level == COLOSSEUM:
            numbers = self.by_task.get(task.get_name(), numbers)
        limits = [excluded.within for excluded in task.world.spec.excluded_factor if excluded.name == self.name]
        for low, high in (limit for limit in limits if limit is not None):
            numbers = {key: _limited(value, low, high) for key, value in numbers.items()}
        return numbers

    @property
    def level_names(self) -> tuple[str, ...]:
        """Names of the levels, as written after the name of the factor."""
        numbered = tuple(str(level) for level in range(1, len(self.levels) + 1))
        return numbered if self.colosseum is None else (*numbered, COLOSSEUM)

    def why_not(self, task: Task) -> str:
        """Return the reason why this factor does not apply to a task; empty if it applies."""
        for excluded in task.world.spec.excluded_factor:
            if excluded.name == self.name and excluded.within is None:
                return excluded.reason
        return "" if _has(task, self.needs) else _REASONS[self.needs]


def _limited(value: float | tuple[float, float], low: float, high: float) -> float | tuple[float, float]:
    """Return a number, or the ends of a range, within limits."""
    if isinstance(value, tuple):
        return min(max(value[0], low), high), min(max(value[1], low), high)
    return min(max(value, low), high)


def _has(task: Task, need: str) -> bool:
    """Return whether a task has the elements that a factor needs."""
    scene = task.world.spec
    if need in ("manipulated", "receiving"):
        return any(body.role == need for body in scene.body)
    if need == "look_alikes":
        return any(body.look_alikes for body in scene.body)
    if need in InstructionsSpec.model_fields:
        return bool(getattr(scene.instructions, need))
    if need == "joints":
        return any(body.joints for body in task.world.bodies.values())
    if need == "placement":
        return not task.is_static_workspace()
    return need != "variations" or task.variation_count() > 1


@cache
def factor_catalogue() -> Mapping[str, Factor]:
    """Return all factors by name, in the order of the catalogue."""
    text = files(__package__).joinpath("catalogue.toml").read_text(encoding="utf-8")
    return {entry["name"]: _factor(**entry) for entry in tomllib.loads(text)["factor"]}


def _factor(levels: list[dict], colosseum: dict | None = None, by_task: Mapping[str, dict] | None = None, **entry: str) -> Factor:
    preset = None if colosseum is None else _numbers(colosseum)
    tasks = {task: _numbers(numbers) for task, numbers in (by_task or {}).items()}
    return Factor(levels=tuple(map(_numbers, levels)), colosseum=preset, by_task=tasks, **entry)  # type: ignore[arg-type]


def _numbers(level: Mapping[str, float | list[float]]) -> Numbers:
    return {key: (value[0], value[1]) if isinstance(value, list) else value for key, value in level.items()}


@dataclass(frozen=True)
class FactorSetting:
    """Factors that apply together, each at its level; without factors it is the setting of level 0."""

    levels: tuple[tuple[str, Level], ...] = ()
    """Name and level of each, in the order of the catalogue."""

    @classmethod
    def of(cls, given: FactorsLike) -> FactorSetting:
        """Return the setting for a text such as `light_color:2+friction:1`, a sequence of such texts, or a mapping.

        Args:
            given: `NAME:LEVEL` joined by `+`, a sequence of these, or name -> level. Level 0 and `""` are no change.

        Raises:
            UnknownName: There is no such factor; the message proposes the most similar one.
            InvalidArgument: A factor has no such level, or occurs twice.
        """
        if isinstance(given, FactorSetting):
            return given
        if isinstance(given, Mapping):
            parts = [(as_text(name, "factor", InvalidArgument), _level(level)) for name, level in given.items()]
        else:
            words = given.split(JOINED) if isinstance(given, str) else given
            if not isinstance(words, Sequence) or not all(isinstance(word, str) for word in words):
                raise InvalidArgument("factors", given, "has to be a text, a sequence of texts, or a mapping", _EXAMPLE)
            parts = [_part(word.strip()) for text in words for word in text.split(JOINED) if word.strip()]
        catalogue, chosen = factor_catalogue(), dict[str, Level]()
        for name, level in parts:
            if name not in catalogue:
                raise UnknownName("factor", name, tuple(catalogue))
            if name in chosen:
                raise InvalidArgument("factors", given, f"names '{name}' twice", "Choose one level for each factor.")
            chosen[name] = level
            if level != 0:
                catalogue[name].numbers(level)
        return cls(tuple((name, chosen[name]) for name in catalogue if chosen.get(name, 0) != 0))

    def __str__(self) -> str:
        """Return the text that `of` accepts, such as `friction:1+light_color:2`; empty without factors."""
        return JOINED.join(f"{name}{LEVEL}{level}" for name, level in self.levels)

    def __bool__(self) -> bool:
        return bool(self.levels)

    def for_task(self, task: Task) -> FactorSetting:
        """Return the setting with `combined` replaced by the factors that it combines in a task."""
        chosen = dict(self.levels)
        level = chosen.pop(COMBINED, 0)
        if level:
            others = (f for f in factor_catalogue().values() if f.group != "language" and f.needs != "placement")
            for factor in (f for f in others if f.name != COMBINED and not f.why_not(task)):
                if level != COLOSSEUM or factor.colosseum is not None:
                    chosen.setdefault(factor.name, level if level == COLOSSEUM else min(int(level), len(factor.levels)))
        return FactorSetting.of(chosen)

    def why_not(self, task: Task) -> str:
        """Return the first factor that does not apply to a task, with the reason; empty if all apply."""
        reasons = ((name, factor_catalogue()[name].why_not(task)) for name, _ in self.levels)
        return next((f"'{name}': {reason}" for name, reason in reasons if reason), "")


def expand_settings(words: Sequence[str], level: Level | str | None = None) -> tuple[str, ...]:
    """Return the settings for words of a command line, each once.

    `light_color:2` and `light_color:2+friction:1` are settings. A factor without a level stands for each of its levels, and
    `all` stands for each factor separately.

    Args:
        words: The words.
        level: Level for factors without one, such as 2 or `colosseum`, at most their highest. None stands for each level.

    Raises:
        UnknownName: There is no such factor.
        InvalidArgument: A factor has no such level.
    """
    wanted = None if level is None else _level(level)
    found: dict[str, None] = {}
    for word in (part for text in words for part in text.replace(",", " ").split()):
        names = tuple(factor_catalogue()) if word == ALL else (word,)
        for name in names:
            found |= dict.fromkeys([str(FactorSetting.of(name))] if LEVEL in name else _levels_of(name, wanted, word == ALL))
    return tuple(setting for setting in found if setting)


def _levels_of(name: str, wanted: Level | None, all_factors: bool) -> list[str]:
    if name not in factor_catalogue():
        raise UnknownName("factor", name, (ALL, *factor_catalogue()))
    factor = factor_catalogue()[name]
    if wanted == COLOSSEUM and factor.colosseum is None and all_factors:
        return []
    if wanted is None:
        return [f"{name}{LEVEL}{level}" for level in range(1, len(factor.levels) + 1)]
    return [str(FactorSetting.of({name: wanted if wanted == COLOSSEUM else min(wanted, len(factor.levels))}))]


FactorsLike = str | Sequence[str] | Mapping[str, Level] | FactorSetting
"""Accepted forms of factors."""
_EXAMPLE = "For example `light_color:2`, or `{'light_color': 2, 'friction': 1}`."


def _part(word: str) -> tuple[str, Level]:
    name, colon, level = word.partition(LEVEL)
    if not colon:
        raise InvalidArgument("factors", word, "lacks a level", f"Write `{name}:1`; `rlbench-pin factors` lists the levels.")
    return name, _level(level)


def _level(level: object) -> Level:
    if level == COLOSSEUM:
        return COLOSSEUM
    text = str(level)
    if isinstance(level, bool) or not text.isascii() or not text.isdigit() or len(text) > 2:
        raise InvalidArgument("level of a factor", level, "has to be 0, 1, 2, 3 or `colosseum`", _EXAMPLE)
    return int(text)
