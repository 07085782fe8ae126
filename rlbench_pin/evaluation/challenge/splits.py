"""Which tasks a learner may practise, and which it meets for the first time in the test."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from rlbench_pin.errors import MissingTasks, UnknownName
from rlbench_pin.evaluation.sets import task_set
from rlbench_pin.tasks import task_names
from rlbench_pin.values import as_flag, as_names

DATA = Path(__file__).with_name("splits.json")
SPLITS_COMMAND = "rlbench-pin challenge splits"


@dataclass(frozen=True)
class MetaSplit:
    """Tasks to practise and tasks to be tested on, without any in common."""

    name: str
    about: str
    """What it is, one sentence."""
    train: tuple[str, ...]
    """The meta-training tasks: open, a learner may do with them what it likes."""
    test: tuple[str, ...]
    """The meta-test tasks, of which a learner gets demonstrations alone."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the tasks that are not built yet."""
        built = set(task_names())
        return tuple(name for name in (*self.train, *self.test) if name not in built)

    def chosen(self, available_only: bool = False, only: Sequence[str] = ()) -> MetaSplit:
        """Return the split with the tasks that are built.

        Args:
            available_only: Leave out those that are not built yet.
            only: Test tasks to keep to; all when none is named.

        Raises:
            MissingTasks: Some are not built yet, and are not to be left out; or none to test on would be left.
        """
        names = as_names(only, "only")
        kept = MetaSplit(self.name, self.about, self.train, tuple(t for t in self.test if not names or t in names))
        missing = kept.missing
        train, test = (tuple(n for n in some if n not in missing) for some in (kept.train, kept.test))
        if missing and not (as_flag(available_only, "available_only") and test):
            raise MissingTasks(self.name, missing, (*train, *test))
        return MetaSplit(self.name, self.about, train, test)


def meta_splits() -> tuple[str, ...]:
    """Return the names of all splits."""
    return tuple(_contents())


def meta_split(name: str) -> MetaSplit:
    """Return a split.

    Args:
        name: `V1`, or a few-shot set: `FS10_V1`, `FS25_V1`, `FS50_V1`, `FS95_V1`.

    Raises:
        UnknownName: No split is called so; proposes the nearest name.
    """
    if not isinstance(name, str) or name not in _contents():
        raise UnknownName("split of the challenge", name, meta_splits(), SPLITS_COMMAND)
    return _contents()[name]


@lru_cache(maxsize=1)
def _contents() -> Mapping[str, MetaSplit]:
    content = json.loads(DATA.read_text(encoding="utf-8"))
    own = {n: MetaSplit(n, s["about"], tuple(s["train"]), tuple(s["test"])) for n, s in content["splits"].items()}
    sets = {name: task_set(name) for name in content["sets"]}
    return {**own, **{n: MetaSplit(n, s.about, s.parts["train"], s.parts["test"]) for n, s in sets.items()}}
