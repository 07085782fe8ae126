"""A task as a gymnasium environment: `gymnasium.make("rlbench_pin/reach_target-state-v0")`."""

from __future__ import annotations

import importlib
import importlib.util
import math
import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from os import PathLike
from types import ModuleType
from typing import Any, ClassVar, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import EzPickle

from rlbench_pin.datasets.layout import ALL_VARIATIONS
from rlbench_pin.environment.actions import ActionMode, JointPositionActionMode
from rlbench_pin.environment.actions.modes import ActionSpec
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.episode import checked_seed
from rlbench_pin.environment.factors import FactorsLike
from rlbench_pin.environment.observations.config import LOW_DIM_FIELDS, Instant
from rlbench_pin.environment.observations.observe import boxed_settings, fitted
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import (
    InvalidActionError,
    InvalidArgument,
    InvalidCamera,
    InvalidValue,
    TaskEnvironmentError,
    UnknownName,
    install_hint,
    shown,
)
from rlbench_pin.gym.ids import MAX_EPISODE_STEPS
from rlbench_pin.observation import LOW_DIM, Demo, Observation
from rlbench_pin.robot import RobotModel
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.sim import CameraView, RendererName, World, look_at
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Task
from rlbench_pin.values import as_array, as_image_size, as_names, as_record, as_whole, names_arguments

VISION_CAMERAS = ("left_shoulder", "right_shoulder", "wrist", "front")
"""Default cameras of vision observations."""

_QUATERNION = ("qx", "qy", "qz", "qw")

GymObservation = dict[str, np.ndarray]


def observation_space(runtime: Runtime, cameras: Sequence[str], image_size: tuple[int, int]) -> spaces.Dict:
    """Return the space of the observations of a running task: float32 boxes, and a uint8 image (h, w, 3) for each camera.

    The bounds are those of the simulation: the effort limits bound joint torques, and the simulator bounds joint velocities.
    """
    instant = Instant(runtime.world, runtime.model, runtime.task)
    boxes: dict[str, spaces.Space[Any]] = {
        name: spaces.Box(*_float32(*part.bounds(instant))) for name, part in LOW_DIM_FIELDS.items() if name in LOW_DIM
    }
    width, height = image_size
    for name in cameras:
        boxes[f"{name}_rgb"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
    return spaces.Dict(boxes)


def _float32(low: FloatArray, high: FloatArray) -> tuple[np.ndarray, np.ndarray]:
    return low.astype(np.float32), high.astype(np.float32)


def as_gym_observation(observation: Observation, space: spaces.Dict) -> GymObservation:
    """Return an observation as an element of its space.

    Values beyond a bound, which occur only in an unstable simulation, are clipped. A task state that is shorter
    than the space, as in a variation with fewer objects, is padded with zeros.

    Raises:
        TaskError: The task state is longer than the space.
    """
    return {name: fitted(name, getattr(observation, name), box) for name, box in space.spaces.items()}  # type: ignore[arg-type]


def action_space(spec: ActionSpec) -> spaces.Box:
    """Return the box (n,), float32, of an action specification."""
    return spaces.Box(*_float32(spec.low, spec.high))


def checked_action(action: object, spec: ActionSpec) -> FloatArray:
    """Return an action as float64 (n,), with a normalised quaternion if it has one.

    Normalisation is necessary because a box space cannot represent the constraint of unit length.

    Raises:
        InvalidActionError: The shape is wrong, or a value is NaN or infinite: an error of the caller, not of the robot.
    """
    try:
        values = as_array(action, "An action").copy()
    except InvalidValue as error:
        raise InvalidActionError(f"{error} Check the output of the policy.") from error
    if values.shape != (spec.size,) or not np.isfinite(values).all():
        names = ", ".join(spec.names)
        raise InvalidActionError(
            f"An action has to be {spec.size} finite numbers ({names}), not {shown(action)}. Check the output of the policy."
        )
    where = _quaternion_index(spec.names)
    norm = np.linalg.norm(values[where])
    if where and norm > 1e-6:
        values[where] /= norm
    return values


def _quaternion_index(names: Sequence[str]) -> list[int]:
    return [names.index(name) for name in _QUATERNION if name in names]


_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")


class WindowMissing(TaskEnvironmentError):
    """A window cannot be opened."""


def why_no_window() -> str | None:
    """Return why a window cannot be opened, with the next step; None if it can."""
    if not any(os.environ.get(name) for name in _SCREENS):
        return "there is no screen (DISPLAY and WAYLAND_DISPLAY are unset). Use render_mode='rgb_array', or run under `xvfb-run`."
    if importlib.util.find_spec("pygame") is None:
        return f"pygame is not installed. {install_hint('human')} brings it, or use render_mode='rgb_array'."
    return None


class Window:
    """A window that shows images; it opens with the first image.

    Args:
        title: Title of the window.

    Raises:
        WindowMissing: There is no screen, or pygame is not installed.
    """

    def __init__(self, title: str) -> None:
        reason = why_no_window()
        if reason is not None:
            raise WindowMissing(f"render_mode='human' opens a window, but {reason}")
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        self._pygame: ModuleType = importlib.import_module("pygame")
        self._title, self._open = title, False

    def show(self, image: np.ndarray) -> None:
        """Show an image, uint8 (h, w, 3).

        Raises:
            WindowMissing: The screen of the environment variables does not respond.
        """
        pygame = self._pygame
        height, width = image.shape[:2]
        if not self._open:
            try:
                pygame.display.init()
                pygame.display.set_mode((width, height))
            except pygame.error as error:
                raise WindowMissing(f"The screen does not respond: {error}. Use render_mode='rgb_array'.") from error
            pygame.display.set_caption(self._title)
            self._open = True
        surface = pygame.surfarray.make_surface(image.swapaxes(0, 1))
        pygame.display.get_surface().blit(surface, (0, 0))
        pygame.event.pump()
        pygame.display.flip()

    def close(self) -> None:
        """Close the window. Further calls have no effect."""
        if self._open:
            self._open = False
            self._pygame.display.quit()


OBSERVATION_MODES = ("state", "vision")
RENDER_MODES = ("rgb_array", "human")
INVALID_ACTIONS = ("continue", "terminate", "raise")
RESET_OPTIONS = ("variation", "reset_to_demo", "factors")

CINEMATIC = CameraView(
    pose=look_at((-0.05, 1.70, 1.80), (0.17, 0.0, 1.13)), fov=float(np.radians(65.0)), size=(640, 360), near=0.05, far=6.0
)
"""The camera of `render`: from the left of the robot, with the whole arm, the table top and the objects on it."""


def episode_steps(robot: str) -> int:
    """Return the maximum number of steps per episode for an arm: 1000, more for slow arms, see `RobotModel.slowness`.

    The registered ids use the number of the Panda. With a slower arm, use
    `gymnasium.make(id, robot="jaco", max_episode_steps=episode_steps("jaco"))`.

    Args:
        robot: Name of the arm.
    """
    return math.ceil(MAX_EPISODE_STEPS * RobotModel(robot_description(robot)).slowness)


class GymnasiumEnv(gymnasium.Env[GymObservation, np.ndarray], EzPickle):
    """One task with the gymnasium interface. Each instance has its own world.

    Observations are a dict of float32 boxes, and of four images with `observation_mode="vision"`. Quaternions in actions are
    normalised. `info` contains `success`, `is_success` (the same), `stable_success`, `text_descriptions`, `variation`,
    `factors`, `error` if the action was invalid, and `refused_opening` if `SafeArm` did not open the fingers.

    A seed passed to `reset` is the seed of that episode, as in `TaskEnvironment.reset(seed=...)`. Without a seed,
    `np_random` draws one.

    Args:
        task: Name or class of the task, or a task file outside the package.
        observation_mode: `state`, or `vision` to add images.
        render_mode: `rgb_array`, `human`, or None.
        action_mode: Action mode, which is copied. None: joint differences and a finger position in one tick.
        variation: Variation of all episodes; -1 draws one for each episode.
        shaped_rewards: Return the shaped reward of the task instead of 1 for success; few tasks have one.
        invalid_action: Effect of an invalid action, such as an unreachable pose: `continue` (nothing moves, reward 0),
            `terminate` (nothing moves, and the episode ends), or `raise`.
        image_size: Width and height of images [px]; None is 128 by 128. Only with `vision`.
        renderer: Renderer of images: `cpu`, `egl` or `auto`.
        cameras: Cameras of vision observations; None selects `VISION_CAMERAS`. Only with `vision`.
        robot: Name of the arm, or path of its TOML file.
        factors: Factors of generalisation of all episodes, such as `light_color:2+friction:1`.

    Raises:
        FactorNotApplicable: One of the factors does not apply to the task.
        UnknownName: There is no such task, mode, camera, arm, choice or argument.
        InvalidArgument: `cameras` or `image_size` were passed without `vision`.
        TaskError: The task file cannot be loaded.
        WindowMissing: The render mode is `human`, without a screen or without pygame.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": list(RENDER_MODES), "render_fps": 20}  # type: ignore[misc]

    @names_arguments
    def __init__(
        self,
        task: str | PathLike[str] | type[Task],
        observation_mode: Literal["state", "vision"] = "state",
        render_mode: Literal["rgb_array", "human"] | None = None,
        action_mode: ActionMode | None = None,
        *,
        variation: int = 0,
        shaped_rewards: bool = False,
        invalid_action: Literal["continue", "terminate", "raise"] = "continue",
        image_size: tuple[int, int] | None = None,
        renderer: RendererName = "cpu",
        cameras: Sequence[str] | None = None,
        robot: str = DEFAULT_ROBOT,
        factors: FactorsLike = "",
    ) -> None:
        EzPickle.__init__(
            self, task, observation_mode, render_mode, action_mode, variation=variation, shaped_rewards=shaped_rewards,
            invalid_action=invalid_action, image_size=image_size, renderer=renderer, cameras=cameras, robot=robot,
            factors=factors,
        )  # fmt: skip
        _check_choice("observation mode", observation_mode, OBSERVATION_MODES)
        _check_choice("handling of invalid actions", invalid_action, INVALID_ACTIONS)
        if render_mode is not None:
            _check_choice("render mode", render_mode, RENDER_MODES)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_modes": list(RENDER_MODES[: 2 if why_no_window() is None else 1])}  # type: ignore[misc]
        self._window = Window(f"rlbench_pin: {task}") if render_mode == "human" else None
        self._invalid_action, self._shaped_rewards = invalid_action, shaped_rewards
        if observation_mode == "state":
            _refuse_images(cameras=cameras, image_size=image_size)
            cameras = ()
        seen = VISION_CAMERAS if cameras is None else as_names(cameras, "cameras", InvalidCamera)
        size = as_image_size((128, 128) if image_size is None else image_size, "image_size", InvalidCamera)
        mode, settings = _own_copy(action_mode), boxed_settings(seen, size)
        self._environment = Environment(
            mode, obs_config=settings, robot_setup=robot, shaped_rewards=shaped_rewards, renderer=renderer, factors=factors
        )
        try:
            self._load(task, variation, seen, size)
        except BaseException:
            self.close()
            raise

    def _load(self, task: str | PathLike[str] | type[Task], variation: int, seen: tuple[str, ...], size: tuple[int, int]) -> None:
        """Load the task and set the spaces."""
        if isinstance(task, str) and not task:
            raise TaskEnvironmentError("No task was given. Pass `task=` with a name, a task file or a class.")
        self._task = self._environment.get_task(task)
        self._task.set_variation(variation)
        self._variation = variation
        self._spec = self._task.action_mode.spec(self._task.runtime)
        self.action_space = action_space(self._spec)
        self._dict_space = observation_space(self._task.runtime, seen, size)
        self.observation_space = self._dict_space  # type: ignore[assignment]

    @property
    def task_environment(self) -> TaskEnvironment:
        """The `TaskEnvironment` of this environment, for demonstrations and states."""
        return self._task

    # The loop ---------------------------------------------------------------------------------------------------

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[GymObservation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seed of the episode and of `np_random`.
            options: `variation`: variation of this episode, -1 to draw it. `reset_to_demo`: demonstration to start from.
            `factors`: factors of this and the next episodes.

        Raises:
            UnknownName: There is no such option.
            TaskEnvironmentError: There is no such variation, the demonstration is of another task, or both options were passed.
            ResetError: The task could not be placed.
        """
        super().reset(seed=None if seed is None else checked_seed(seed))
        chosen = _checked_options(options)
        if "factors" in chosen:
            self._task.set_factors(chosen["factors"])
        demo = chosen.get("reset_to_demo")
        if demo is not None:
            _, observation = self._task.reset_to_demo(demo)
        else:
            episode = int(self.np_random.integers(2**31)) if seed is None else seed
            _, observation = self._task.reset(seed=episode, variation=chosen.get("variation", self._variation))
        self._show()
        return self._observed(observation), self._info(success=False)

    def step(self, action: np.ndarray) -> tuple[GymObservation, float, bool, bool, dict[str, Any]]:
        """Run one action to its end.

        Returns:
            Observation, reward, whether the episode has ended by success or failure, False, and `info`.

        Raises:
            InvalidActionError: The action has the wrong shape or is not finite, or is invalid with `invalid_action="raise"`.
        """
        values = checked_action(action, self._spec)
        try:
            observation, reward, terminated = self._task.step(values)
        except InvalidActionError as error:
            if self._invalid_action == "raise":
                raise
            return self._refused(error)
        self._show()
        info = self._info(success=self._task.succeeded)
        if self._task.refused_opening is not None:
            info["refused_opening"] = self._task.refused_opening
        return self._observed(observation), reward, terminated, False, info

    def _refused(self, error: InvalidActionError) -> tuple[GymObservation, float, bool, bool, dict[str, Any]]:
        """Return the result of an invalid action, which changes nothing."""
        self._show()
        reward = (self._task.task.reward() or 0.0) if self._shaped_rewards else 0.0
        info = {**self._info(success=False), "error": str(error)}
        return self._observed(self._task.get_observation()), reward, self._invalid_action == "terminate", False, info

    def _observed(self, observation: Observation) -> GymObservation:
        return as_gym_observation(observation, self._dict_space)

    def _info(self, success: bool) -> dict[str, Any]:
        return {
            "success": success,
            "is_success": success,
            "stable_success": success and self._task.success_is_stable(),
            "text_descriptions": self._task.get_task_descriptions(),
            "variation": self._task.runtime.variation,
            "factors": self._task.episode.factors,
        }

    # Images and the end ---------------------------------------------------------------------------------------

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """Return an image from the side, uint8 (360, 640, 3), or show it with `render_mode="human"`."""
        return render_from_side(self._task.world, self.render_mode, self._window)

    def _show(self) -> None:
        if self._window is not None:
            self.render()

    def close(self) -> None:
        """Close the world and the window. Further calls have no effect."""
        self._environment.shutdown()
        if self._window is not None:
            self._window.close()


def render_from_side(world: World, render_mode: str | None, window: Window | None) -> np.ndarray | None:
    """Return an image of a world from the side, uint8 (360, 640, 3), or show it if there is a window.

    Without a render mode, return no image and emit a warning of gymnasium.
    """
    if render_mode is None:
        gymnasium.logger.warn("render() returns no image without a render_mode. Pass render_mode='rgb_array' to make().")
        return None
    image = world.renderer.image(CINEMATIC)
    if window is None:
        return image
    window.show(image)
    return None


def _own_copy(mode: ActionMode | None) -> ActionMode:
    """Return a copy, so that environments with one action mode do not share it."""
    if mode is None:
        return JointPositionActionMode()
    try:
        return deepcopy(mode)
    except (RuntimeError, TypeError) as error:  # a mode of the user's own that holds a solver of C++; no mode at all
        raise TaskEnvironmentError(
            f"This {type(mode).__name__} cannot be copied: {error}. Pass a new one to each environment."
        ) from error


def _checked_options(options: Mapping[str, Any] | None) -> Mapping[str, Any]:
    chosen = dict(as_record({} if options is None else options, Mapping, "options", InvalidArgument))  # type: ignore[type-abstract]
    for name in chosen:
        if name not in RESET_OPTIONS:
            raise UnknownName("reset option", str(name), RESET_OPTIONS)
    demo, variation = chosen.get("reset_to_demo"), chosen.get("variation", ALL_VARIATIONS)
    if demo is not None and not isinstance(demo, Demo):
        raise TaskEnvironmentError(f"options['reset_to_demo'] has to be a Demo from `get_demos`, not {type(demo).__name__}.")
    if demo is not None and "variation" in chosen:
        raise TaskEnvironmentError("A demonstration sets its own variation. Pass 'reset_to_demo' or 'variation', not both.")
    if demo is not None and "factors" in chosen:
        raise TaskEnvironmentError("A demonstration sets its own factors. Pass 'reset_to_demo' or 'factors', not both.")
    as_whole(variation, "options['variation'], -1 to draw one,", InvalidArgument)
    return chosen


def _refuse_images(**settings: object) -> None:
    """Raise InvalidArgument for image settings without image observations."""
    for name, value in settings.items():
        if value is not None:
            hint = "Use the `-vision-v0` id, or observation_mode='vision'."
            raise InvalidArgument(name, value, "is a setting of images, which `state` observations do not have", hint)


class UnknownChoice(UnknownName, ValueError):
    """An argument has a value that is not one of the choices."""


def _check_choice(kind: str, value: object, choices: tuple[str, ...]) -> None:
    if not isinstance(value, str) or value not in choices:
        raise UnknownChoice(kind, value, choices)  # type: ignore[arg-type] # it shows whatever it is
