"""What forms ask for a condition is what its class takes."""

from __future__ import annotations

import inspect

from rlbench_pin.builder.document import condition_kinds
from rlbench_pin.tasks import conditions


def test_every_condition_has_a_form_but_those_of_code() -> None:
    """All of the vocabulary; a list that the task keeps is not a form's."""
    assert {kind.name for kind in condition_kinds()} == set(conditions.__all__) - {"Condition", "ListEmpty"}


def test_parameters_are_those_of_the_class() -> None:
    """Names, order and defaults, arm and hand left out, each with what its docstring says."""
    for kind in condition_kinds():
        signature = inspect.signature(getattr(conditions, kind.name)).parameters
        shown = {name: p for name, p in signature.items() if name not in ("robot", "gripper")}
        assert [parameter.name for parameter in kind.parameters] == list(shown)
        for parameter in kind.parameters:
            default = shown[parameter.name].default
            assert parameter.required == (default is inspect.Parameter.empty)
            assert parameter.required or parameter.default == default
            assert parameter.text.endswith(".") and ":" not in parameter.text.partition(". ")[2], parameter
        assert kind.text.endswith(".")


def test_kinds_say_what_a_form_asks_for() -> None:
    """A few of them."""
    kinds = {kind.name: {p.name: p.kind for p in kind.parameters} for kind in condition_kinds()}
    assert kinds["Detected"] == {"thing": "place", "sensor": "sensor", "negated": "flag"}
    assert kinds["DetectedSeveral"] == {"things": "places", "sensor": "sensor", "count": "whole"}
    assert kinds["JointMoved"] == {"joint": "joint", "distance": "number"}
    assert kinds["AllOf"] == {"members": "conditions"} and kinds["NothingGrasped"] == {}
    assert kinds["FollowPath"]["points"] == "points" and kinds["FollowPath"]["frame"] == "frame"
