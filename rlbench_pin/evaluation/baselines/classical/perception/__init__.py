"""What the pictures show: clouds, clusters, colours, and where known models stand."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.classical.perception.cloud import Cloud, View, back_project, look, thinned
from rlbench_pin.evaluation.baselines.classical.perception.clusters import clusters, rectangle
from rlbench_pin.evaluation.baselines.classical.perception.colors import PALETTE, lit_color, name_of
from rlbench_pin.evaluation.baselines.classical.perception.models import Axis, KnownModel
from rlbench_pin.evaluation.baselines.classical.perception.registration import Located, locate

__all__ = [
    "PALETTE",
    "Axis",
    "Cloud",
    "KnownModel",
    "Located",
    "View",
    "back_project",
    "clusters",
    "lit_color",
    "locate",
    "look",
    "name_of",
    "rectangle",
    "thinned",
]
