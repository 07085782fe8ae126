"""What baselines that look know beforehand: the surfaces of models and of the arm, and the names of colours."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.sight.arm import arm_surface
from rlbench_pin.evaluation.baselines.sight.colors import PALETTE, distances, lit_color, name_of
from rlbench_pin.evaluation.baselines.sight.models import Axis, KnownModel

__all__ = ["PALETTE", "Axis", "KnownModel", "arm_surface", "distances", "lit_color", "name_of"]
