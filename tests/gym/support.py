"""Playing episodes."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np


def episode(env: gymnasium.Env[Any, Any], seed: int | None, steps: int = 5) -> list[Any]:
    """Return everything that an episode of fixed actions yields."""
    rng = np.random.default_rng(0)
    low, high = env.action_space.low, env.action_space.high  # type: ignore[attr-defined]
    return [env.reset(seed=seed), *(env.step(rng.uniform(low, high).astype(np.float32)) for _ in range(steps))]
