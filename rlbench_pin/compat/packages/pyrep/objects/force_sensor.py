"""Force sensors: what presses on a body, from the contacts of the last physics step."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from pyrep.const import ObjectType as ConstType
from pyrep.objects.object import Object
from rlbench_pin.compat.things import ObjectType, detection


class ForceSensor(Object):
    """Measures the contact forces on a body or link of the scene.

    Scene files have no force sensors: name the body, or `<body>/<link>`, that is pressed.
    """

    kinds: ClassVar[tuple[ObjectType, ...]] = ("force_sensor", "shape")

    def get_type(self) -> ConstType:
        """Return FORCE_SENSOR, whatever it measures at."""
        return ConstType.FORCE_SENSOR

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        """Return force (3,) [N] and torque (3,) [N m] of the normal contact forces, in its own frame, about its origin."""
        return detection.contact_wrench(self.table, self.element)
