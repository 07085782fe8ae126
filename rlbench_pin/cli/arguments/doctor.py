"""What `rlbench-pin doctor` takes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Doctor:
    """Say what works here: take a picture with each renderer, write a film, name the libraries."""

    json: bool = False
    """Print JSON for programs."""
