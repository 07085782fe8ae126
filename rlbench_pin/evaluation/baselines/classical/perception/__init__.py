"""What the pictures show: clouds, clusters, colours, and where known models stand."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.classical.perception.cloud import Cloud, View, back_project, look, thinned
from rlbench_pin.evaluation.baselines.classical.perception.clusters import clusters, rectangle
from rlbench_pin.evaluation.baselines.classical.perception.obstacles import as_world, filled_boxes, near
from rlbench_pin.evaluation.baselines.classical.perception.registration import Located, locate, outside
from rlbench_pin.evaluation.baselines.sight.colors import PALETTE, lit_color, name_of
from rlbench_pin.evaluation.baselines.sight.models import Axis, KnownModel

__all__ = [
    "PALETTE",
    "Axis",
    "Cloud",
    "KnownModel",
    "Located",
    "View",
    "as_world",
    "back_project",
    "clusters",
    "filled_boxes",
    "lit_color",
    "locate",
    "look",
    "name_of",
    "near",
    "outside",
    "rectangle",
    "thinned",
]
