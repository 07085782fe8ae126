"""What can be said of a body: how it stands, its colour and size, its joints."""

from __future__ import annotations

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Check, Choice, Fold, Item, Note, Number, Slider
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import BodySpec, JointSpec, resolve_asset
from rlbench_pin.tasks import COLORS
from rlbench_pin.urdf import UrdfJoint, read_urdf

OWN = "as in its file"
"""No colour of the palette."""
_OTHER = "another"
_MOVABLE = ("revolute", "continuous", "prismatic")
_TURN = 3.1416


def body_items(session: Session, body: BodySpec) -> list[Item]:
    """Return the switches, colour, scale and joints of a body."""
    name = body.name

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set(name, key, value, merge=f"{key} of {name}"))

    return [
        Note(f"`{body.asset}`"),
        Check("Fixed", body.fixed, lambda value: change("fixed", value), hint="Welded to its place; otherwise it falls"),
        Check("Collides", body.collides, lambda value: change("collides", value), hint="Off for markers that are only seen"),
        _color_item(session, body),
        Number("Scale", body.scale, lambda value: change("scale", round(value, 4)), 0.05, 0.0001, 100.0),
        *_joint_items(session, body),
    ]


def _color_item(session: Session, body: BodySpec) -> Choice:
    shades = {color.name: color.rgb for color in COLORS}
    found = OWN
    if body.color is not None:
        found = next((word for word, rgb in shades.items() if rgb == tuple(body.color[:3])), _OTHER)
    options = (OWN, *shades, *([_OTHER] if found == _OTHER else []))

    def choose(word: str) -> None:
        if word != _OTHER:
            session.do(lambda document: document.set(body.name, "color", shades.get(word)))

    return Choice("Colour", found, options, choose, hint="The palette from which variations draw")


def _joint_items(session: Session, body: BodySpec) -> list[Item]:
    try:
        joints = [j for j in read_urdf(resolve_asset(session.spec, body.asset)).joints if j.kind in _MOVABLE]
    except RlbenchPinError as error:
        return [Note(str(error))]
    return [_joint_item(session, body, joint) for joint in joints]


def _joint_item(session: Session, body: BodySpec, joint: UrdfJoint) -> Fold:
    name = f"{body.name}/{joint.name}"
    said = next((j for j in session.spec.joint if j.name == name), JointSpec(name=name))
    least, most = (round(limit, 4) if abs(limit) < 1e3 else default for limit, default in zip(joint.limits, (-_TURN, _TURN)))
    unit = "m" if joint.kind == "prismatic" else "rad"

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set(name, key, value, merge=f"{key} of {name}"))

    def slide(value: float) -> None:
        change("position", min(max(round(value, 4), joint.limits[0]), joint.limits[1]))

    return Fold(
        joint.name,
        [
            Slider(f"Starts at [{unit}]", round(said.position, 4), slide, least, max(most, least + 0.001)),
            Number("Friction", said.friction, lambda value: change("friction", round(value, 4)), 0.01, 0.0),
            Check("Locked", said.locked, lambda value: change("locked", value), hint="Held until the task unlocks it"),
        ],
    )
