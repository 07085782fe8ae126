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
"""Name -> `module:factory` of the learners of this package."""
_FORMS = "`module:factory` or `file.py:factory`, with `?key=value&...` after it for arguments"
SHOTS = (1, 5, 20)
"""Numbers of demonstrations of each task in version 1 of the challenge."""
MAX_SHOTS = 1000
"""Maximum number of demonstrations of a task."""
MIN_SECRET, MAX_SECRET = 16, 2**20
"""Smallest and largest size of a secret [bytes]."""


class ChallengeConflict(RlbenchPinError):
    """The folder of a run of the challenge contains another run."""

    @classmethod
    def between(cls, path: Path, name: str, then: object, now: object) -> ChallengeConflict:
        """Return the error for a setting that differs."""
        return cls(
            f"'{path}' belongs to a run with {name} = {shown(then)}, but this run has {name} = {shown(now)}. "
            "Choose another folder with `--out`."
        )


class ChallengeStopped(RlbenchPinError):
    """A run of the challenge was stopped before its end; finished work is kept."""

    def __init__(self, stage: str, done: int, wanted: int, folder: Path) -> None:
        self.stage, self.done, self.wanted, self.folder = stage, done, wanted, folder
        super().__init__(f"{stage}: {done} of {wanted} are done and kept in '{folder}'. Continue with `--resume`.")


class NoDemonstrations(RlbenchPinError):
    """A test task has too few demonstrations, because the planner failed."""

    def __init__(self, task: str, seed: int, cause: str) -> None:
        self.task, self.seed, self.cause = task, seed, cause
        super().__init__(
            f"There is no demonstration of '{task}' from seed {seed}: {cause} Use another `--seed`, which has other "
            f"demonstrations. `rlbench-pin check {task}` prints how often this happens."
        )


def refuse_links(folder: Path) -> None:
    """Raise ChallengeConflict if the folder of a run contains a link; only the run writes there, and it follows no links."""
    for inner, folders, files in os.walk(folder):
        for name in (*folders, *files):
            if (path := Path(inner, name)).is_symlink():
                raise ChallengeConflict(f"'{path}' is a link, and the folder of a run must not contain links. Delete it.")


@dataclass(frozen=True)
class MetaSplit:
    """Meta-training tasks and meta-test tasks, with no task in common."""

    name: str
    about: str
    """Description, one sentence."""
    train: tuple[str, ...]
    """The meta-training tasks, which a learner may use without restrictions."""
    test: tuple[str, ...]
    """The meta-test tasks. A learner gets only demonstrations of these."""

    def chosen(self, only: Sequence[str]) -> MetaSplit:
        """Return the split with only these test tasks; with all test tasks when none is named."""
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
        UnknownName: No split has this name; proposes the nearest name.
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
    """Check that a learner exists, and return its `module:factory` or `file.py:factory`, with arguments.

    Raises:
        UnknownName: The reference is a single word, and no learner of this package has this name.
        PolicyReferenceError: There is no such module, file or factory, or the reference has neither form.
    """
    if not isinstance(reference, str) or not reference:
        raise PolicyReferenceError(reference, f"names no learner; the form of a reference is {_FORMS}")
    name, _, query = reference.partition("?")
    if ":" not in name:
        if name not in LEARNERS:
            raise UnknownName("few-shot learner", name, tuple(LEARNERS))
        return f"{LEARNERS[name]}?{query}" if query else LEARNERS[name]
    if reference.startswith(("sb3:", "lerobot:", "unix:", "tcp:", "openpi:", "vla-eval:")):
        raise PolicyReferenceError(reference, "is a policy, not a few-shot learner", f"Use {_FORMS}.")
    return find_policy(reference).target


def read_secret(path: Path | str) -> bytes:
    """Return all bytes of a file with a secret.

    The host of a challenge keeps the file until the challenge is over. Then the host publishes it, so that everyone can compute
    all seeds again.

    Raises:
        InvalidArgument: There is no such file, or it has fewer than 16 bytes or more than 1 MB.
    """
    path = as_path(path, "secret")
    try:
        with path.open("rb") as file:
            secret = file.read(MAX_SECRET + 1)
    except OSError as error:
        raise InvalidArgument("secret", str(path), f"cannot be read: {error.strerror}", "Check the path.") from error
    if not MIN_SECRET <= len(secret) <= MAX_SECRET:
        hint = "Make one with `head -c 32 /dev/urandom > FILE`."
        raise InvalidArgument("secret", str(path), f"has to have {MIN_SECRET} to {MAX_SECRET} bytes", hint)
    return secret


@dataclass(frozen=True, kw_only=True)
class ChallengeConfig:
    """Learner, split and numbers of demonstrations of a run. The same settings give the same results.

    Raises:
        InvalidArgument: A number, a text or a switch cannot be used (also an InvalidValue).
        UnknownName: There is no such learner or split.
        PolicyReferenceError: The reference names no learner.
    """

    learner: str
    """`nearest`, or a reference to a learner of your own: `module:factory`, `file.py:factory`."""
    split: str = "V1"
    """Name of the split, with its training tasks and test tasks."""
    shots: tuple[int, ...] = SHOTS
    """Numbers of demonstrations of each test task. A smaller number uses the first demonstrations of a larger one."""
    only: tuple[str, ...] = ()
    """Only these test tasks; all test tasks of the split when empty."""
    episodes: int = 25
    """Number of episodes of each test task; the episodes are the same for each number of demonstrations."""
    seed: int = 0
    """Seed of the test episodes and of the demonstrations."""
    max_steps: int | None = None
    """Maximum number of actions of an episode; None uses the number of the learner or of its action mode."""
    max_seconds: float = SECONDS
    """Maximum simulated time of an episode with the Panda [s]. Arms with slower joints have a longer limit."""
    time_limit: float = 30.0
    """Wall-clock time limit of a policy for one answer [s]."""
    start_limit: float = 300.0
    """Time limit for the start of a learner [s]."""
    adapt_limit: float = 3600.0
    """Time limit for the adaptation of a learner to one task [s]."""
    train_limit: float = 1e6
    """Time limit for the training of a learner on the meta-training tasks [s]."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm, or path of its TOML file."""
    secret: bytes = field(default=b"", repr=False)
    """Mixed into the seeds of demonstrations and episodes; empty for none. See `read_secret`."""

    def __post_init__(self) -> None:
        """Check every value, and convert it to a plain Python type."""
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
            raise InvalidArgument("shots", (), "has to contain a number", "Version 1 of the challenge has 1, 5 and 20.")
        for task in self.only:
            as_choice(task, f"test task of {self.split}", meta_split(self.split).test)
        find_learner(self.learner)

    @property
    def secret_sha256(self) -> str:
        """SHA-256 of the secret; "" without a secret. Results contain this checksum, but never the secret."""
        return hashlib.sha256(self.secret).hexdigest() if self.secret else ""

    @property
    def drawing_seed(self) -> int:
        """Seed that determines the seeds of demonstrations and episodes: `seed`, or with a secret its keyed hash, below 2^48.

        HMAC-SHA256 of `rlbench_pin challenge/SEED`, first 6 bytes, the highest first.
        """
        if not self.secret:
            return self.seed
        return int.from_bytes(hmac.digest(self.secret, f"rlbench_pin challenge/{self.seed}".encode(), "sha256")[:6], "big")

    def tasks(self) -> MetaSplit:
        """Return the tasks of the run."""
        return meta_split(self.split).chosen(self.only)

    def evaluation(self, shots: int) -> EvaluationConfig:
        """Return the settings of the evaluation with `shots` demonstrations."""
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
