"""Records of settings: a rule for each attribute, and a base class that refuses attributes that there are not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from typing import ClassVar

from rlbench_pin.errors import InvalidValue, UnknownSetting
from rlbench_pin.values.single import as_flag, as_number, as_record, as_whole

Rule = Callable[[object, str], object]
"""Takes a value and what it is called; returns the value as it is kept, or raises InvalidValue."""
FINITE: Rule = as_number
POSITIVE: Rule = partial(as_number, above=0.0)
NOT_NEGATIVE: Rule = partial(as_number, least=0.0)
FLAG: Rule = as_flag


LARGEST_COUNT = 2**31 - 1
"""Settings that count something are at most this."""


def counted(least: int, most: int = LARGEST_COUNT) -> Rule:
    """Return the rule of whole numbers from `least` to `most`."""
    return partial(as_whole, least=least, most=most)


def one_of(*choices: str) -> Rule:
    """Return the rule of a word that is one of some."""

    def rule(value: object, what: str) -> str:
        if not isinstance(value, str) or value not in choices:
            raise InvalidValue(what, value, f"is one of {', '.join(choices)}")
        return value

    return rule


def record_of(kind: type) -> Rule:
    """Return the rule of records of one class."""

    def rule(value: object, what: str) -> object:
        return as_record(value, kind, what)

    return rule


def ruled(*rules: tuple[Rule, str]) -> dict[str, Rule]:
    """Return name -> rule from pairs of a rule and the names it is for, separated by blanks."""
    return {name: rule for rule, names in rules for name in names.split()}


def check_settings(settings: object, rules: Mapping[str, Rule]) -> None:
    """Raise InvalidValue unless every attribute of a record keeps its rule; frozen records call this after `__init__`."""
    for name, rule in rules.items():
        rule(getattr(settings, name), f"{type(settings).__name__}.{name}")


class Settings:
    """Base of settings that may be changed at any time: unknown attributes are refused, values are checked when they are set.

    What is known are the fields of the dataclass, what the classes define or annotate, and names with an underscore.
    """

    rules: ClassVar[Mapping[str, Rule]] = {}
    """Attribute -> how it is checked; what is not named is taken as it is."""
    closed: ClassVar[bool] = True
    """Whether unknown attributes are refused."""

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute.

        Raises:
            UnknownSetting: There is none of that name; names the nearest (also an AttributeError).
            InvalidValue: The value makes no sense.
        """
        rule = self.rules.get(name)
        if rule is not None:
            value = rule(value, f"{type(self).__name__}.{name}")
        elif self.closed and not name.startswith("_") and name not in (known := _known_settings(type(self))):
            raise UnknownSetting(type(self).__name__, name, known)
        super().__setattr__(name, value)


def _known_settings(kind: type) -> tuple[str, ...]:
    """Return the names that instances of a settings class may have."""
    named = [f.name for f in fields(kind)] if is_dataclass(kind) else []
    named += [name for base in kind.__mro__[:-1] for name in (*vars(base), *vars(base).get("__annotations__", ()))]
    names = dict.fromkeys(name for name in named if not name.startswith("_") and name not in ("rules", "closed"))
    return tuple(name for name in names if not callable(getattr(kind, name, None)))
