"""Vector environments whose processes start at the first use and end with `close`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from rlbench_pin.environment.episode import checked_seed
from rlbench_pin.errors import InvalidActionError, InvalidArgument, InvalidValue
from rlbench_pin.values import as_array, as_finite

AnyEnv = gymnasium.Env[Any, Any]


class LazyAsyncVectorEnv(VectorEnv[Any, Any, Any]):
    """An asynchronous vector environment that starts its processes at the first use.

    The processes are spawned, so they share no state with this process. After `close` the environment may be used again.

    Args:
        makers: Functions that each create one environment, in its process.
        like: An environment with the spaces and the metadata of all; it may be closed.
        autoreset_mode: Time of the reset after the end of an episode.
    """

    def __init__(
        self, makers: Sequence[Callable[[], AnyEnv]], like: AnyEnv, autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP
    ) -> None:
        self._makers, self._autoreset_mode = tuple(makers), autoreset_mode
        self._running: AsyncVectorEnv | None = None
        self.num_envs = len(self._makers)
        self.single_observation_space, self.single_action_space = like.observation_space, like.action_space
        self.observation_space = batch_space(like.observation_space, self.num_envs)
        self.action_space = batch_space(like.action_space, self.num_envs)
        self.render_mode = like.render_mode
        self.metadata = {**like.metadata, "autoreset_mode": autoreset_mode}

    @property
    def running(self) -> AsyncVectorEnv:
        """The vector environment; the first access starts it."""
        if self._running is None:
            self._running = AsyncVectorEnv(self._makers, context="spawn", autoreset_mode=self._autoreset_mode)
        return self._running

    @property
    def is_running(self) -> bool:
        """Whether the processes are running."""
        return self._running is not None

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode in each environment.

        Raises:
            InvalidArgument: `seed` is not an integer, the first of consecutive seeds, or a list with one integer per environment.
        """
        if isinstance(seed, list | tuple) and len(seed) != self.num_envs:
            raise InvalidArgument(
                "seed", seed, f"has to be one whole number, or {self.num_envs} whole numbers, one for each environment"
            )
        for one in seed if isinstance(seed, list | tuple) else (seed,):
            if one is not None:
                checked_seed(one)
        return self.running.reset(seed=seed, options=options)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Run one action in each environment.

        Raises:
            InvalidActionError: The number or the shape of the actions is wrong, or they are not finite; nothing has moved.
        """
        self._check(actions)
        return self.running.step(actions)

    def _check(self, actions: Any) -> None:
        try:
            array = as_finite(as_array(actions, "The actions"), "The actions")
        except InvalidValue as error:
            raise InvalidActionError(str(error)) from error
        if array.shape != self.action_space.shape:
            raise InvalidActionError(
                f"The actions have to have shape {self.action_space.shape}, not {array.shape}. Pass one per environment."
            )

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
        """Return an image of each environment."""
        return self.running.render()

    def close(self, **kwargs: Any) -> None:
        """End all processes. Further calls have no effect."""
        running, self._running = self._running, None
        if running is not None:
            running.close(**kwargs)
