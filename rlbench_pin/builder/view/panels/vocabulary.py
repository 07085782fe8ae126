"""What the things of a scene are for conditions: bodies, places, joints, frames, sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from rlbench_pin.builder.document import Argument, ConditionForm, ConditionKind, Named, Parameter
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import SceneSpec, resolve_asset
from rlbench_pin.urdf import read_urdf

Kind = Literal["body", "place", "joint", "frame", "sensor"]
_FIRST: Mapping[str, Argument] = {"number": 0.1, "whole": 1, "flag": False, "numbers": (1.0, 0.0, 0.0)}
_WORDS = {"place": "body or frame", "conditions": "condition", "places": "body or frame"}


@dataclass(frozen=True)
class Vocabulary:
    """What a scene has.

    Args:
        spec: The scene.
        graspable: Bodies that the hand may hold come first.
    """

    spec: SceneSpec
    graspable: tuple[str, ...] = ()

    def things(self, kind: str) -> tuple[Named, ...]:
        """Return what there is of a kind of parameter."""
        bodies = sorted((body.name for body in self.spec.body), key=lambda name: name not in self.graspable)
        frames = [thing.name for thing in (*self.spec.frame, *self.spec.sensor, *self.spec.region, *self.spec.waypoint)]
        if kind == "body":
            return tuple(Named("body", name) for name in bodies)
        if kind == "sensor":
            return tuple(Named("sensor", sensor.name) for sensor in self.spec.sensor)
        if kind == "joint":
            return tuple(Named("joint", name) for name in self.joints())
        if kind == "frame":
            return tuple(Named("frame", name) for name in frames)
        return (*(Named("body", name) for name in bodies), *(Named("frame", name) for name in frames))

    def joints(self) -> tuple[str, ...]:
        """Return `<body>/<joint>` of all joints that move."""
        found = []
        for body in self.spec.body:
            try:
                joints = read_urdf(resolve_asset(self.spec, body.asset)).joint_limits
            except RlbenchPinError:
                continue
            found += [f"{body.name}/{joint}" for joint in joints]
        return tuple(found)

    def first(self, kind: ConditionKind) -> ConditionForm | None:
        """Return a condition of a kind about the first things that fit; None when the scene lacks one."""
        arguments: dict[str, Argument] = {}
        for parameter in kind.parameters:
            if parameter.required:
                value = self._first(parameter)
                if value is None:
                    return None
                arguments[parameter.name] = value
        return ConditionForm(kind.name, arguments)

    def lacking(self, kind: ConditionKind) -> str:
        """Return what the scene lacks for a condition of a kind."""
        missing = (p.kind for p in kind.parameters if p.required and self._first(p) is None)
        word = next(missing, "thing")
        return _WORDS.get(word, word)

    def _first(self, parameter: Parameter) -> Argument:
        if parameter.kind in _FIRST:
            return _FIRST[parameter.kind]
        if parameter.kind == "points":
            return ((0.0, 0.0, 0.0),)
        if parameter.kind == "conditions":
            return (ConditionForm("NothingGrasped"),)
        things = self.things("place" if parameter.kind == "places" else parameter.kind)
        if not things:
            return None
        return (things[0],) if parameter.kind == "places" else things[0]
