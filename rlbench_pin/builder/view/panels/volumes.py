"""What can be said of regions and sensors."""

from __future__ import annotations

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Choice, Item, Number, Vector
from rlbench_pin.scene import RegionSpec, SensorSpec

SHAPES = ("box", "cylinder", "sphere")
"""Of sensors."""
_LEAST = 0.001


def region_items(session: Session, region: RegionSpec) -> list[Item]:
    """Return the size of a region."""
    size = region.size

    def change(value: tuple[float, float, float]) -> None:
        x, y, z = (round(abs(v), 4) for v in value)
        new = max(x, _LEAST), max(y, _LEAST), z
        session.do(lambda document: document.set(region.name, "size", new, merge=f"size of {region.name}"))

    return [Vector("Size x y z [m]", (size[0], size[1], size[2]), change, hint="Flat when its height is 0")]


def sensor_items(session: Session, sensor: SensorSpec) -> list[Item]:
    """Return the shape of a sensor, and its size."""
    name, size = sensor.name, sensor.size

    def resize(number: int, value: float) -> None:
        new = tuple(round(max(abs(value), _LEAST), 4) if k == number else v for k, v in enumerate(size))
        session.do(lambda document: document.set(name, "size", new, merge=f"size of {name}"))

    def reshape(shape: str) -> None:
        x, z = size[0], size[-1]
        new = {"box": (x, size[1] if len(size) == 3 else x, z), "cylinder": (x, z), "sphere": (x,)}[shape]
        session.do(lambda document: document.set_several(name, {"shape": shape, "size": new}))

    words = {"box": ("x", "y", "z"), "cylinder": ("Diameter", "Length"), "sphere": ("Diameter",)}[sensor.shape]
    numbers = [
        Number(f"{word} [m]", size[k], lambda value, k=k: resize(k, value), 0.01, _LEAST)  # type: ignore[misc]
        for k, word in enumerate(words)
    ]
    return [Choice("Shape", sensor.shape, SHAPES, reshape), *numbers]
