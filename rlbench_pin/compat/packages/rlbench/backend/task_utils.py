"""Random objects for tasks."""

from __future__ import annotations

from itertools import count

import numpy as np

from pyrep.objects.object import Object
from pyrep.objects.shape import Shape
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.scene.spec import BodySpec

_SOLIDS = 25
"""Number of convex solids in the assets."""
_SCALES = (0.85, 1.2)
"""Bounds of the random scale of a solid."""


def sample_procedural_objects(task_base: Object, num_samples: int, mass: float = 0.1) -> list[Shape]:
    """Add convex solids of random shape and size to the scene, drawn from numpy's global generator.

    They are placed side by side, 0.1 m above the base, and are removed after the episode.

    Args:
        task_base: Object above which the solids are placed.
        num_samples: Number of solids.
        mass: Mass of each solid [kg].
    """
    world = Simulator.current().world
    free = (name for name in (f"object{i}" for i in count()) if name not in world.bodies)
    forms = np.random.choice(_SOLIDS, num_samples, replace=num_samples > _SOLIDS)
    x, y, z = (float(value) for value in task_base.get_position())
    shapes = []
    for index, form in enumerate(forms.tolist()):
        name = next(free)
        pose = (x, y + 0.1 * (index - (num_samples - 1) / 2.0), z + 0.1, 0.0, 0.0, 0.0, 1.0)
        asset, scale = f"objects/convex/convex_{form:02d}.urdf", float(np.random.uniform(*_SCALES))
        world.add_body(name, BodySpec(name=name, parent="world", asset=asset, pose=pose, scale=scale))
        shape = Shape(name)
        shape.set_mass(mass)
        shapes.append(shape)
    return shapes
