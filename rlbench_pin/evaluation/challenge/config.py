"""Settings of a run of the challenge: learner, split of the tasks, numbers of demonstrations, seeds; and the errors of a run."""

from __future__ import annotations

import hashlib
import hmac
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from rlbench_pin.errors import InvalidArgument, RlbenchPinError, UnknownName, shown
from rlbench_pin.evaluation.policies.policy import PolicyReferenceError
from rlbench_pin.evaluation.policies.references import find_policy
from rlbench_pin.evaluation.run.config import LARGEST_START, MAX_EPISODES, SECONDS, EvaluationConfig
from rlbench_pin.evaluation.sets import task_set
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.values import as_choice, as_names, as_number, as_path, as_record, as_several, as_text, as_whole

DATA = Path(__file__).with_name("splits.json")
LEARNERS: Mapping[str, str] = {"nearest": "rlbench_pin.baselines.few_shot:Nearest"}
"""Name -> `module:factory` of the learners that this package brings."""
_FORMS = "`module:factory` or `file.py:factory`, with `?key=value&...` behind it for arguments"
SHOTS = (1, 5, 20)
"""Demonstrations of each task, as the challenge v1 has them."""
MAX_SHOTS = 1000
"""Demonstrations of a task at most."""
MIN_SECRET, MAX_SECRET = 16, 2**20
"""Bytes of a secret."""


class ChallengeConflict(RlbenchPinError):
    """Where a run of the challenge is to be written, there is another one."""

    @classmethod
    def between(cls, path: Path, name: str, then: object, now: object) -> ChallengeConflict:
        """Return the error that says what differs."""
        return cls(
            f"'{path}' is of a run with {name} = {shown(then)}, this is {name} = {shown(now)}. "
            "Choose another folder with `--out`."
        )


class ChallengeStopped(RlbenchPinError):
    """A run of the challenge was stopped before its end; what is done is kept."""

    def __init__(self, stage: str, done: int, wanted: int, folder: Path) -> None:
        self.stage, self.done, self.wanted, self.folder = stage, done, wanted, folder
        super().__init__(f"{stage}: {done} of {wanted} are done and kept in '{folder}'. Go on with `--resume`.")


class NoDemonstrations(RlbenchPinError):
    """A task of the test could not be demonstrated often enough."""

    def __init__(self, task: str, seed: int, cause: str) -> None:
        self.task, self.seed, self.cause = task, seed, cause
        super().__init__(
            f"There is no demonstration of '{task}' from seed {seed}: {cause} `rlbench-pin check {task}` shows how often that "
            "happens; another `--seed` uses other demonstrations."
        )


def refuse_links(folder: Path) -> None:
    """Raise ChallengeConflict where the folder of a run contains a link: the harness alone writes there, and follows none."""
    for inner, folders, files in os.walk(folder):
        for name in (*folders, *files):
            if (path := Path(inner, name)).is_symlink():
                raise ChallengeConflict(f"'{path}' is a link. The folder of a run contains none; delete it.")


@dataclass(frozen=True)
class MetaSplit:
    """Tasks to practise and tasks to be tested on, without any in common."""

    name: str
    about: str
    """Description, one sentence."""
    train: tuple[str, ...]
    """The meta-training tasks: open, a learner may do with them what it likes."""
    test: tuple[str, ...]
    """The meta-test tasks, of which a learner gets demonstrations alone."""

    def chosen(self, only: Sequence[str]) -> MetaSplit:
        """Return the split with the test tasks to keep to; all when none is named."""
        names = as_names(only, "only")
        return MetaSplit(self.name, self.about, self.train, tuple(t for t in self.test if not names or t in names))


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
        raise UnknownName("split of the challenge", name, meta_splits(), "rlbench-pin challenge splits")
    return _contents()[name]


@lru_cache(maxsize=1)
def _contents() -> Mapping[str, MetaSplit]:
    content = json.loads(DATA.read_text(encoding="utf-8"))
    own = {n: MetaSplit(n, s["about"], tuple(s["train"]), tuple(s["test"])) for n, s in content["splits"].items()}
    sets = {name: task_set(name) for name in content["sets"]}
    return {**own, **{n: MetaSplit(n, s.about, s.parts["train"], s.parts["test"]) for n, s in sets.items()}}


def find_learner(reference: str) -> str:
    """Return `module:factory` or `file.py:factory`, with arguments, of a learner, after checking that it exists.

    Raises:
        UnknownName: It is a single word, and no learner of this package is called so.
        PolicyReferenceError: There is no such module, file or factory, or it has neither form.
    """
    if not isinstance(reference, str) or not reference:
        raise PolicyReferenceError(reference, f"names no learner; one is called {_FORMS}")
    name, _, query = reference.partition("?")
    if ":" not in name:
        if name not in LEARNERS:
            raise UnknownName("few-shot learner", name, tuple(LEARNERS))
        return f"{LEARNERS[name]}?{query}" if query else LEARNERS[name]
    if reference.startswith(("sb3:", "lerobot:", "unix:", "tcp:", "openpi:", "vla-eval:")):
        raise PolicyReferenceError(reference, "is a policy, not a few-shot learner", f"One is called {_FORMS}.")
    return find_policy(reference).target


def read_secret(path: Path | str) -> bytes:
    """Return the secret in a file, all its bytes.

    A host keeps the file until a challenge is over, then publishes it, so that everyone can compute all seeds again.

    Raises:
        InvalidArgument: There is no such file, or it has fewer than 16 bytes or more than 1 MB.
    """
    path = as_path(path, "secret")
    try:
        with path.open("rb") as file:
            secret = file.read(MAX_SECRET + 1)
    except OSError as error:
        raise InvalidArgument("secret", str(path), f"cannot be read: {error.strerror}") from error
    if not MIN_SECRET <= len(secret) <= MAX_SECRET:
        hint = "`head -c 32 /dev/urandom > FILE` makes one."
        raise InvalidArgument("secret", str(path), f"has to have {MIN_SECRET} to {MAX_SECRET} bytes", hint)
    return secret


@dataclass(frozen=True, kw_only=True)
class ChallengeConfig:
    """Which learner, on which split, with how many demonstrations. The same settings give the same results.

    Raises:
        InvalidArgument: A number, a text or a switch cannot be used (also an InvalidValue).
        UnknownName: There is no such learner or split.
        PolicyReferenceError: The reference leads to no learner.
    """

    learner: str
    """`nearest`, or a reference to a learner of your own: `module:factory`, `file.py:factory`."""
    split: str = "V1"
    """Which tasks are trained and tested on."""
    shots: tuple[int, ...] = SHOTS
    """Numbers of demonstrations of each test task; the fewer are the first of the more."""
    only: tuple[str, ...] = ()
    """Test tasks to keep to; all of the split when none is named."""
    episodes: int = 25
    """Episodes of each test task, for each number of demonstrations; always the same ones."""
    seed: int = 0
    """Seed of the episodes of the test, and of the demonstrations."""
    max_steps: int | None = None
    """Actions of an episode at most; None leaves it to the learner and its action mode."""
    max_seconds: float = SECONDS
    """Simulated time of an episode at most [s], with the Panda; slower arms have more."""
    time_limit: float = 30.0
    """Time that a policy has for one answer [s], of a clock on the wall."""
    start_limit: float = 300.0
    """Time that a learner has to start [s]."""
    adapt_limit: float = 3600.0
    """Time that a learner has to adapt to a task [s]."""
    train_limit: float = 1e6
    """Time that a learner has to practise the meta-training tasks [s]."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm, or path of its TOML file."""
    secret: bytes = field(default=b"", repr=False)
    """Mixed into the seeds of demonstrations and episodes; empty for none. See `read_secret`."""

    def __post_init__(self) -> None:
        """Check every value, and keep it as plain Python has it."""
        shots = (as_whole(k, "shots", InvalidArgument, least=1, most=MAX_SHOTS) for k in as_several(self.shots, "shots"))
        checked = {
            "learner": as_text(self.learner, "learner", InvalidArgument),
            "split": meta_split(self.split).name,
            "shots": tuple(sorted(set(shots))),
            "only": tuple(dict.fromkeys(as_names(self.only, "only", InvalidArgument))),
            "episodes": as_whole(self.episodes, "episodes", InvalidArgument, least=1, most=MAX_EPISODES),
            "seed": as_whole(self.seed, "seed", InvalidArgument, least=0, most=LARGEST_START),
            "robot": robot_description(self.robot).reference,
            "secret": as_record(self.secret, bytes, "secret"),
        }
        for name in ("max_seconds", "time_limit", "start_limit", "adapt_limit", "train_limit"):
            checked[name] = as_number(getattr(self, name), name, InvalidArgument, above=0.0, most=1e7)
        if self.max_steps is not None:
            checked["max_steps"] = as_whole(self.max_steps, "max_steps", InvalidArgument, least=1)
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if not self.shots:
            raise InvalidArgument("shots", (), "leaves nothing to test", "The challenge v1 has 1, 5 and 20.")
        for task in self.only:
            as_choice(task, f"test task of {self.split}", meta_split(self.split).test)
        find_learner(self.learner)

    @property
    def secret_sha256(self) -> str:
        """SHA-256 of the secret, "" without one. Results record it; never the secret."""
        return hashlib.sha256(self.secret).hexdigest() if self.secret else ""

    @property
    def drawing_seed(self) -> int:
        """Seed from which those of demonstrations and episodes follow: `seed`, or with a secret its keyed hash, below 2^48.

        HMAC-SHA256 of `rlbench_pin challenge/SEED`, first 6 bytes, the highest first.
        """
        if not self.secret:
            return self.seed
        return int.from_bytes(hmac.digest(self.secret, f"rlbench_pin challenge/{self.seed}".encode(), "sha256")[:6], "big")

    def tasks(self) -> MetaSplit:
        """Return the tasks of the run."""
        return meta_split(self.split).chosen(self.only)

    def evaluation(self, shots: int) -> EvaluationConfig:
        """Return the evaluation with so many demonstrations."""
        return EvaluationConfig(
            policy=f"{self.learner}, {shots} shot{'s' if shots > 1 else ''}",
            tasks=self.tasks().test,
            task_set=f"challenge {self.split}" + (f", secret sha256:{self.secret_sha256}" if self.secret else ""),
            episodes=self.episodes,
            seed=self.drawing_seed,
            max_steps=self.max_steps,
            max_seconds=self.max_seconds,
            time_limit=self.time_limit,
            start_limit=self.start_limit,
            robot=self.robot,
            tell_task=False,
            policy_seed_key=hmac.digest(self.secret, b"rlbench_pin policy", "sha256").hex() if self.secret else "",
        )


def demonstration_seed(seed: int, task: str, index: int) -> int:
    """Return the seed of demonstration `index` of a test task, 0 <= seed < 2^53: a hash. Evaluations begin at 2^53.

    Args:
        seed: `ChallengeConfig.drawing_seed`.
        task: Name of the task.
        index: Number of the demonstration.
    """
    text = f"rlbench_pin challenge demonstration/{seed}/{task}/{index}".encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "big") >> 11
