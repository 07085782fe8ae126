"""A task as a gymnasium environment: `gymnasium.make("rlbench/reach_target-state-v0")`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import gymnasium
import numpy as np

from rlbench.action_modes.action_mode import ActionMode, JointPositionActionMode
from rlbench.backend.task import Task
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.utils import name_to_task_class
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import UnknownName
from rlbench_pin.gym.environment import (
    OBSERVATION_MODES,
    RENDER_MODES,
    VISION_CAMERAS,
    GymObservation,
    Window,
    as_gym_observation,
    observation_space,
    render_from_side,
)
from rlbench_pin.observation import LOW_DIM, Demo, Observation


class UnknownMode(UnknownName, ValueError):
    """An unknown observation mode or render mode."""


def convert_dtype_to_float32_if_float(dtype: Any) -> Any:
    """Return float32 for floating-point types, and any other type unchanged."""
    return np.float32 if np.issubdtype(dtype, np.floating) else dtype


class RLBenchEnv(gymnasium.Env[GymObservation, np.ndarray]):
    """One task with the interface of gymnasium. Each instance has its own simulator, so a process can have several.

    Observations are a dict of float32 boxes, and of four images with `observation_mode="vision"`. `info` contains
    `text_descriptions`, `success`, `is_success` and `variation`.

    Args:
        task_class: The task, by class or by name.
        observation_mode: `state`, or `vision` for images as well.
        render_mode: `rgb_array`, `human`, or None.
        action_mode: The action mode; None is joint differences and a finger position in one tick.

    Attributes:
        rlbench_env: The RLBench environment.
        rlbench_task_env: The RLBench task environment.
        obs_config: Contents of observations.

    Raises:
        UnknownMode: No such observation mode or render mode (also a ValueError).
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["human", "rgb_array"], "render_fps": 4}  # type: ignore[misc]

    def __init__(
        self,
        task_class: type[Task] | str,
        observation_mode: str = "state",
        render_mode: str | None = None,
        action_mode: ActionMode | None = None,
    ) -> None:
        if observation_mode not in OBSERVATION_MODES:
            raise UnknownMode("observation mode", str(observation_mode), OBSERVATION_MODES)
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise UnknownMode("render mode", str(render_mode), RENDER_MODES)
        self.task_class = name_to_task_class(task_class) if isinstance(task_class, str) else task_class
        self.observation_mode, self.render_mode = observation_mode, render_mode
        self.action_mode = JointPositionActionMode() if action_mode is None else action_mode
        self._cameras = VISION_CAMERAS if observation_mode == "vision" else ()
        self.obs_config = _settings(self._cameras)
        self._window = Window(f"rlbench: {self.task_class.__name__}") if render_mode == "human" else None
        self._simulator: Simulator | None = None
        self.rlbench_env = Environment(self.action_mode, obs_config=self.obs_config, headless=True)
        before = Simulator.running
        Simulator.make_current(None)
        try:
            self._load()
        except BaseException:
            self.close()
            Simulator.make_current(before)
            raise

    def _load(self) -> None:
        """Start a simulator, load the task and define the spaces."""
        self.rlbench_env.launch()
        self._simulator = Simulator.current()
        self.rlbench_task_env = self.rlbench_env.get_task(self.task_class)
        self.rlbench_task_env.reset()
        runtime = self.rlbench_task_env.runtime
        self._dict_space = observation_space(runtime, self._cameras, self.obs_config.front_camera.image_size)
        self.observation_space = self._dict_space  # type: ignore[assignment]
        low, high = self.action_mode.action_bounds()
        self.action_space = gymnasium.spaces.Box(
            np.asarray(low, dtype=np.float32), np.asarray(high, dtype=np.float32), dtype=np.float32
        )

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[GymObservation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seed of numpy's global generator, from which the episode is drawn.
            options: `reset_to_demo`: a demonstration whose start is restored.
        """
        super().reset(seed=seed)
        Simulator.make_current(self._simulator)
        if seed is not None:
            np.random.seed(seed)
        demo: Demo | None = (options or {}).get("reset_to_demo")
        task = self.rlbench_task_env
        descriptions, observation = task.reset() if demo is None else task.reset_to_demo(demo)
        self._show()
        return self._observed(observation), self._info(descriptions, success=False)

    def step(self, action: np.ndarray) -> tuple[GymObservation, float, bool, bool, dict[str, Any]]:
        """Execute one action to its end.

        Returns:
            Observation, reward, whether the episode has ended by success or failure, False, and `info`.

        Raises:
            InvalidActionError: The action is invalid; the world has not changed.
        """
        Simulator.make_current(self._simulator)
        observation, reward, terminated = self.rlbench_task_env.step(np.asarray(action, dtype=np.float64))
        self._show()
        success = self.rlbench_task_env.succeeded
        info = self._info(self.rlbench_task_env.get_task_descriptions(), success=success)
        return self._observed(observation), reward, terminated, False, info

    def _observed(self, observation: Observation) -> GymObservation:
        return as_gym_observation(observation, self._dict_space)

    def _info(self, descriptions: list[str], success: bool) -> dict[str, Any]:
        variation = self.rlbench_task_env.runtime.variation
        return {"text_descriptions": descriptions, "success": success, "is_success": success, "variation": variation}

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """Return an image from the side, uint8 (360, 640, 3), or show it with `render_mode="human"`."""
        if self.render_mode is not None:
            Simulator.make_current(self._simulator)
        return render_from_side(self.rlbench_task_env.runtime.world, self.render_mode, self._window)

    def _show(self) -> None:
        if self._window is not None:
            self.render()

    def close(self) -> None:
        """Close the simulator and the window; further calls have no effect."""
        if self._simulator is not None:
            Simulator.make_current(self._simulator)
            self.rlbench_env.shutdown()
            self._simulator = None
        if self._window is not None:
            self._window.close()


def _settings(cameras: tuple[str, ...]) -> ObservationConfig:
    """Return observation settings with exactly the contents of the spaces."""
    config = ObservationConfig()
    config.set_all(False)
    for name in LOW_DIM:
        setattr(config, name, True)
    for name in cameras:
        config.camera(name).rgb = True
    return config
