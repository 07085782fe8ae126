"""What a motion has to keep to: collision checks of configurations, and of whole paths."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from rlbench_pin.planning.path import JointPath, edge_is_free
from rlbench_pin.planning.plan import PlannerConfig
from rlbench_pin.planning.proof import Prover
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.spatial import FloatArray


@dataclass(eq=False)
class Rules:
    """The rules of one motion, which `collision` has begun."""

    collision: CollisionModel
    """Checks configurations."""
    config: PlannerConfig
    """Resolution and budget of the checks."""
    prover: Prover
    """Proves paths of this motion."""
    world: bool = True
    """Whether the world counts; otherwise the arm alone, with what it holds."""
    doubts: int = 0
    """Paths that passed every sample and could not be certified."""
    measured: int = 0
    """Configurations in which proofs measured distances."""

    def is_free(self, q: FloatArray) -> bool:
        """Say whether a configuration (n,) keeps the rules."""
        return not self.collision.collides(q)

    def first_violation(self, path: JointPath) -> float | None:
        """Return where on a path (0..1) the rules are broken, or not proven to be kept; None when the path is good."""
        hit = path.first_collision(self.is_free, self.config.check_step)
        if hit is None and self.config.certify:
            proof = self.prover.prove(path, self.config.certify_checks)
            hit = proof.doubt
            self.doubts += hit is not None
            self.measured += proof.checks
        return hit

    def blocked_edges(self, path: FloatArray, step: float) -> list[int]:
        """Return the edges of a polyline (m, n) that are not free, looking every `step` [rad]."""
        return [i for i, (a, b) in enumerate(pairwise(path)) if not edge_is_free(a, b, self.is_free, step)]
