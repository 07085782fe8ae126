"""The tasks of rlbench_pin as a benchmark of vla-eval. No other module imports vla-eval.

The configuration of vla-eval names `rlbench_pin.evaluation.vla_eval_benchmark:RlbenchPinBenchmark`; docs/policies.md has an
example.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rlbench_pin.errors import MissingExtra
from rlbench_pin.evaluation.policies.mapping import load_mapping
from rlbench_pin.evaluation.policies.wires import vla_eval_specs
from rlbench_pin.evaluation.run.hosting import EpisodeHost, hosting_config
from rlbench_pin.observation import Observation

try:
    from vla_eval.benchmarks.base import StepBenchmark, StepResult
    from vla_eval.specs import DimSpec
except ModuleNotFoundError as _error:
    raise MissingExtra("The benchmark for vla-eval", _error.name or "vla_eval", "vla-eval") from _error


class RlbenchPinBenchmark(StepBenchmark):
    """Tasks of rlbench_pin, evaluated by vla-eval in its synchronous mode.

    Seeds, variations, start states and limits are those of `rlbench-pin evaluate`; a limit ends the episode. `success` means
    success at any moment, `stable_success` that it still holds 1 s later with the arm stationary.

    Args:
        mapping: Preset or TOML file with the keys of the observations and the meaning of the numbers of an action.
        protocol: Name of a protocol, such as `peract18`, or path of its TOML file. It fixes tasks, episodes and limits.
        tasks: Names of tasks, task files or sets, instead of a protocol.
        episodes: Number of episodes of each task of `tasks`, spread evenly over its variations; None is 25. Set
            `episodes_per_task` of vla-eval to the same number.

    Raises:
        InvalidArgument: Neither `protocol` nor `tasks` is given, or both are.
        UnknownName: There is no such mapping, protocol or task; proposes the nearest name.
        MappingError: The mapping cannot be used, or is for another arm.
        ProtocolConflict: The mapping has other cameras, image sizes or actions than the protocol.
    """

    render_backends = frozenset({"cpu", "gpu"})
    """Both are accepted; images are always rendered on the CPU."""

    @classmethod
    def configure_render(cls, mode: str) -> dict[str, str]:
        """Return the environment variables that the renderer needs: none."""
        return {}

    def __init__(
        self, mapping: str, protocol: str | None = None, tasks: Sequence[str] | None = None, episodes: int | None = None
    ) -> None:
        super().__init__()
        self._host = EpisodeHost(hosting_config("vla-eval", protocol, tasks, episodes), load_mapping(mapping))
        self._instruction = ""
        keys = self._host.mapping.images.items()
        self._video = next((f"{image.camera}_rgb" for _, image in keys if image.product == "rgb"), "")

    def get_tasks(self) -> list[dict[str, Any]]:
        """Return the rows of the results, in the order of the protocol or the list."""
        suite = self._host.config.task_set or "rlbench_pin"
        return [{"name": row, "suite": suite} for row in self._host.rows]

    def reset(self, task: dict[str, Any]) -> Observation:
        """Start the episode `episode_idx` of a row."""
        self._instruction, seen = self._host.reset(task["name"], task.get("episode_idx", 0))
        self._recorder.record_video(getattr(seen, self._video, None))
        return seen

    def step(self, action: dict[str, Any]) -> StepResult:
        """Play one action."""
        seen, end = self._host.step(action)
        self._recorder.record_video(getattr(seen, self._video, None))
        return StepResult(obs=seen, reward=float(end == "success"), done=end is not None, info={})

    def make_obs(self, raw_obs: Observation, task: dict[str, Any]) -> dict[str, Any]:
        """Return an observation with the keys of the mapping."""
        return self._host.mapping.encode(raw_obs, self._instruction)

    def get_step_result(self, step_result: StepResult) -> dict[str, Any]:
        """Return whether the episode succeeded, whether success is stable, and how it ended."""
        end = self._host.end or "steps"  # `max_steps` of vla-eval was smaller than ours
        return {"success": end == "success", "stable_success": self._host.success_is_stable(), "end": end}

    def get_metric_keys(self) -> dict[str, str]:
        """Return the metrics for which vla-eval computes means."""
        return {"success": "mean", "stable_success": "mean"}

    def get_metadata(self) -> dict[str, Any]:
        """Return the limits of an episode and the number of episodes of a row."""
        return {
            "max_steps": self._host.max_steps,
            "max_episodes_per_task": min(len(items) for items in self._host.rows.values()),
        }

    def get_action_spec(self) -> dict[str, DimSpec]:
        """Return the specification of an action, which vla-eval compares with that of the server."""
        return _dim_specs(vla_eval_specs(self._host.mapping)["action_spec"])

    def get_observation_spec(self) -> dict[str, DimSpec]:
        """Return the specification of an observation, which vla-eval compares with that of the server."""
        return _dim_specs(vla_eval_specs(self._host.mapping)["observation_spec"])

    def cleanup(self) -> None:
        """Free the environment."""
        self._host.close()


def _dim_specs(specs: dict[str, dict[str, Any]]) -> dict[str, DimSpec]:
    return {name: DimSpec.from_dict(spec) for name, spec in specs.items()}
