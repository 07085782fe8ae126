"""What learners are called, and what that leads to; nothing of a learner runs here."""

from __future__ import annotations

from collections.abc import Mapping

from rlbench_pin.errors import UnknownName
from rlbench_pin.evaluation.policies.policy import PolicyReferenceError
from rlbench_pin.evaluation.policies.references import find_policy

LEARNERS: Mapping[str, str] = {"nearest": "rlbench_pin.evaluation.baselines.few_shot.nearest:Nearest"}
"""Name -> `module:factory` of the learners that this package brings."""
_FORMS = "`module:factory` or `file.py:factory`, with `?key=value&...` behind it for arguments"


def find_learner(reference: str) -> str:
    """Return `module:factory` or `file.py:factory`, with arguments, of a learner, after a look at whether it exists.

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
    if reference.startswith(("sb3:", "lerobot:", "unix:", "tcp:")):
        raise PolicyReferenceError(reference, "is a policy, not a few-shot learner", f"One is called {_FORMS}.")
    return find_policy(reference).target
