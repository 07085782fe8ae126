"""Proof that a motion is free of collisions everywhere, not only at samples."""

from rlbench_pin.planning.proof.prover import Certificate, Prover, certify
from rlbench_pin.planning.proof.shapes import ArmShapes

__all__ = ["ArmShapes", "Certificate", "Prover", "certify"]
