"""The process of a learner: `python -m rlbench_pin.evaluation.challenge.learner_process SOCKET PIPE LEARNER`.

The protocol is that of policies, with further requests before the first `reset`:

    {"call": "wants"}                                                   {"ok": {"pictures": "all" | "first"}}
    {"call": "meta_train", "tasks": [names], "robot": name}             {"ok": the result, a map or None}
    {"call": "recall", "learned": map}                                  {"ok": None}
    {"call": "frames", "demonstration": number, "instructions": [texts], "observations": [maps]}     {"ok": None}
    {"call": "adapt"}                                                   {"ok": None}
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from typing import Any

from rlbench_pin.evaluation.challenge.learner import Demonstration, TrainingTask
from rlbench_pin.evaluation.policies.policy_process import settings_of
from rlbench_pin.evaluation.policies.policy_server import Answers, Channel, NoPolicy, converse, describe_error
from rlbench_pin.evaluation.policies.references import POLICY, make_named
from rlbench_pin.evaluation.policies.wire import decode_context, decode_observation
from rlbench_pin.processes.child import connect_to_owner

PARTS = ("adapt", "meta_train", "action_mode", "obs_config")
"""Methods of a learner."""
Answer = dict[str, Any]


class LearnerAnswers(Answers):
    """Answers the requests of a challenge with one learner, and with the policy that it makes.

    Args:
        make: Makes the learner.
    """

    def __init__(self, make: Callable[[], Any]) -> None:
        super().__init__(self._one_learner, settings_of)
        self._make_learner, self._learner = make, None
        self._shown: dict[int, tuple[tuple[str, ...], list[Any]]] = {}
        self._acting: Answers | None = None

    def to(self, question: Mapping[str, Any]) -> Answer:
        """Return the answer to a request."""
        calls: dict[Any, Callable[[Mapping[str, Any]], Answer]] = {
            "wants": self._wants, "meta_train": self._meta_train, "recall": self._recall, "frames": self._frames,
            "adapt": self._adapt,
        }  # fmt: skip
        call = question.get("call")
        if call in ("reset", "act"):
            missing = {"error": "There is no policy yet. Call `adapt` first.", "kind": "wrong question"}
            return missing if self._acting is None else self._acting.to(question)
        if call not in calls:
            return super().to(question)
        try:
            return calls[call](question)
        except NoPolicy as error:
            return {"error": str(error), "kind": "wrong answer"}
        except Exception as error:  # whatever the learner raises
            traceback.print_exc()
            return {"error": describe_error(error), "kind": "crashed"}

    def _one_learner(self) -> Any:
        if self._learner is None:
            self._learner = self._make_learner()
        return self._learner

    def _wants(self, question: Mapping[str, Any]) -> Answer:
        return {"ok": {"pictures": getattr(self._one_learner(), "pictures", "all")}}

    def _meta_train(self, question: Mapping[str, Any]) -> Answer:
        tasks = [TrainingTask(name, question["robot"]) for name in question["tasks"]]
        learned = self._one_learner().meta_train(tasks)
        if learned is not None and not isinstance(learned, Mapping):
            raise NoPolicy(f"`meta_train` returned a {type(learned).__name__}; it must return a map or None.")
        return {"ok": learned}

    def _recall(self, question: Mapping[str, Any]) -> Answer:
        self._one_learner().recall(question["learned"])
        return {"ok": None}

    def _frames(self, question: Mapping[str, Any]) -> Answer:
        _, frames = self._shown.setdefault(question["demonstration"], (tuple(question["instructions"]), []))
        frames += [decode_observation(fields) for fields in question["observations"]]
        return {"ok": None}

    def _adapt(self, question: Mapping[str, Any]) -> Answer:
        learner, shown = self._one_learner(), [self._shown[number] for number in sorted(self._shown)]
        policy = learner.adapt([Demonstration(said, tuple(frames)) for said, frames in shown])
        lacking = [part for part in POLICY if not hasattr(policy, part)]
        if lacking:
            raise NoPolicy(f"`adapt` returned a {type(policy).__name__}, which is not a policy: it lacks `{lacking[0]}`. Add it.")
        mine, its = dict(settings_of(learner)), dict(settings_of(policy))
        if any(mine[name] != its[name] for name in ("action_mode", "observation")):
            raise NoPolicy("The policy of `adapt` must have the action mode and the observations of its learner.")
        self._shown.clear()
        self._acting = Answers(lambda: policy, settings_of, decode_observation, decode_context)
        return {"ok": None}


def main() -> None:
    """Answer until the owner closes the socket."""
    connection, (target,) = connect_to_owner()
    converse(Channel(connection), LearnerAnswers(lambda: make_named(target, "learner", PARTS)))


if __name__ == "__main__":
    main()
