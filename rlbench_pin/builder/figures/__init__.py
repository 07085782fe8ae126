"""What a browser is shown of a scene: meshes, colours and places, as in simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.builder.figures.figures import Figures
from rlbench_pin.builder.figures.places import Places, places_at_rest
from rlbench_pin.front_door import front_door

__all__ = ["Figures", "Places", "places_at_rest"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
