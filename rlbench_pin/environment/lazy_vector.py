"""A vector environment that builds its environments when it is first used, and frees them when it is closed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space

AnyEnv = gymnasium.Env[Any, Any]


class LazyVectorEnv(VectorEnv[Any, Any, Any]):
    """Stands for a synchronous or asynchronous vector environment, so that many can be made and few exist at a time.

    After `close` it may be used again, and then builds everything anew.

    Args:
        makers: Make one environment each; they are sent to other processes when asynchronous.
        like: An environment with the spaces and the metadata of all; it may be closed.
        asynchronous: Each environment in a process of its own, which is spawned and so shares nothing with this one.
    """

    def __init__(self, makers: Sequence[Callable[[], AnyEnv]], like: AnyEnv, asynchronous: bool = False) -> None:
        self._makers, self._asynchronous = tuple(makers), asynchronous
        self._running: SyncVectorEnv | AsyncVectorEnv | None = None
        self.num_envs = len(self._makers)
        self.single_observation_space, self.single_action_space = like.observation_space, like.action_space
        self.observation_space = batch_space(like.observation_space, self.num_envs)
        self.action_space = batch_space(like.action_space, self.num_envs)
        self.render_mode = like.render_mode
        self.metadata = {**like.metadata, "autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}

    @property
    def running(self) -> SyncVectorEnv | AsyncVectorEnv:
        """The vector environment itself, built now if need be."""
        if self._running is None:
            build = _spawned if self._asynchronous else SyncVectorEnv
            self._running = build(self._makers)
        return self._running

    @property
    def is_running(self) -> bool:
        """Whether the environments exist."""
        return self._running is not None

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode in each environment."""
        return self.running.reset(seed=seed, options=options)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Run one action in each environment."""
        return self.running.step(actions)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Call a method of each environment, or read an attribute."""
        return self.running.call(name, *args, **kwargs)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Read an attribute of each environment."""
        return self.running.get_attr(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each environment."""
        self.running.set_attr(name, values)

    def render(self) -> Any:
        """Return a picture of each environment."""
        return self.running.render()

    def close(self, **kwargs: Any) -> None:
        """Free all environments; may be called again."""
        running, self._running = self._running, None
        if running is not None:
            running.close(**kwargs)


def _spawned(makers: Sequence[Callable[[], AnyEnv]]) -> AsyncVectorEnv:
    """Return a process for each environment."""
    return AsyncVectorEnv(makers, context="spawn")
