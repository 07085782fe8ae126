"""Doors of files, tasks, recordings, evaluation, checks, gymnasium, and the settings of environments."""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np

from rlbench_pin import checking, datasets, environment, evaluation, gym, observation, recording, scene, tasks
from rlbench_pin.datasets import formats
from rlbench_pin.environment import Discrete, ExtraCamera, JointPosition, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.evaluation import EvaluationConfig
from rlbench_pin.recording import ImageConfig, RecordConfig
from rlbench_pin.robot import RobotModel, robot_description
from tests.demos_for_tests import make_demo
from tests.evaluation.results.made import results
from tests.fuzz.doors import Door, Fresh, functions, methods, parameters_of

SKIPPED = frozenset({
    "RandomizeEvery", "RelativeFrame",  # enumerations of Python
    "Color", "BodySnapshot", "Shape", "WorldSnapshot",  # records that files and worlds fill
    "EpisodeEntry", "KeptTask", "Trial", "DemoTrial", "NoopTrial", "KeyFramesTrial", "RandomTrial", "ReachTrial",
    "FrictionTrial", "RepeatTrial", "RefusedOpening", "WordsTrial",
    "Rate", "NoopEpisode", "Move", "TaskInfo", "StoredEpisode", "RecordReport", "ReplayResult", "Command",
    "CheckProgress", "Failure", "Item", "Reach", "TaskReport", "TaskState", "DemoOutcome", "EnvironmentState",
    "SegmentReport", "ActionSpec", "EpisodeItem", "EpisodeOutcome", "EvaluationProgress", "PolicyContext", "PolicyMapping",
    "Reference", "TaskSet", "Comparison", "Pairs", "TaskComparison", "PValues", "Summary",
    "TaskSummary", "Estimate", "Table", "ProtocolRow", "ProtocolSummary", "EpisodeDifference",
    "Verification",  # records that doors return, or policies are given
    "Follower", "TrackingProblem", "Waypoint", "Task",  # what the package makes itself; users read them
    "ChallengeProgress", "Demonstration", "LearningCurve", "ShotsResult", "MetaSplit", "TrainingTask",  # likewise
    "KeyFramePolicy",  # a base class
    "hold", "record", "rerender", "ProcessEngine", "run_trials", "explain_failure", "follow_demo", "follow_leg", "plan_trial",
    "record_legs", "evaluate", "run_challenge", "make_env", "GymnasiumEnv", "LeRobotEnv", "LazyAsyncVectorEnv", "Runtime",
    "TaskEnvironment", "Cameras", "Camera",
    "Aligned", "AllOf", "AnyOf", "Detected", "DetectedSeveral", "FollowPath", "Grasped", "HasColor", "InOrder", "JointMoved",
    "ListEmpty", "NothingGrasped", "TipInside",  # have cases elsewhere: doors_work, doors_world, test_actions
    "SpawnBoundary", "clearance", "easiest_top_grasp", "free_direction", "place_task", "settle", "at_rest",
    "swap_places",  # likewise, or asked in every tick
})  # fmt: skip
SMALL = EvaluationConfig(policy="noop", tasks=("reach_target",), episodes=1, max_seconds=0.1)
"""The smallest evaluation."""
LONG = ("close", "get_task", "step", "set_state", "get_demos", "reset_to_demo", "remove_camera", "put", "try_demo")
"""These have cases elsewhere, or need what a made-up demonstration has not."""
RATES = {"first": 0.5, "second": 0.9, "shared": 0.5}
RECORDS = ("BodySpec", "SensorSpec", "FrameSpec", "RegionSpec", "WaypointSpec", "PlacementSpec")
"""Records with a pose."""
PLAYED = frozenset(
    {
        "export_dataset",
        "key_frame_actions",
        "key_frames_succeed",
        "convert_by_playing",
        "expert_action",
        "replay_demo",
        "verify",
        "verify_results",
        "folder_demos",
        "read_folder",
        "read_recording",
    }
)
"""Likewise: their good arguments are refused here."""
LOOSE = {"key_frames": "demo", "rgb_handles_to_mask": "rgb", "encode_demo": "demo", "holm": "p_values"}


def samples(folder: Path, task: TaskEnvironment) -> dict[str, object]:
    """Return good arguments by name; paths to write to are new ones below `folder`."""
    root, numbers = folder / "data", itertools.count()
    first = datasets.DatasetWriter(root).add(make_demo(seed=1))
    entry = datasets.read_manifest(root, "reach_target")[0]
    new = Fresh(lambda: folder / f"new{next(numbers)}")
    mode = MoveArmThenGripper(JointPosition(), Discrete())
    plain: dict[str, object] = {
        "root": root, "path": first, "task": "reach_target", "variation": 0, "episode": 0,
        "demo": Fresh(lambda: make_demo(seed=5)),
        "out": new, "folder": new, "amount": 1, "roots": [root], "data": b"x", "number": 0, "place": root,
        "stored": ["reach_target"],
        "tasks": ["reach_target"], "name": "reach_target", "reference": f"{first}#front_rgb/0", "size": (16, 16),
        "sha256": entry.sha256,
        "contents": {"a.py": b"1"}, "file": "a.py", "files": [], "config": RecordConfig(tasks=("reach_target",), episodes=1),
        "images": ImageConfig(products=()), "rng": Fresh(lambda: np.random.default_rng(0)), "action_mode": mode,
        "mode": JointPosition(),
        "model": RobotModel(robot_description("panda")), "names": ["CartesianMPC"], "trials": [], "summaries": [],
        "words": ["reach_target"],
        "obs_config": low_dim_config(), "task_name": "reach_target", "variance": 0.1, "pose": np.array([0.0, 0, 1, 0, 0, 0, 1]),
        "arm_action_mode": JointPosition(), "gripper_action_mode": Discrete(), "rgb": np.zeros((2, 2, 3)), "namespace": "fuzz",
        "asset": "objects/cube_small/cube_small.urdf", "actions": [], "observations": [], "value": True, "camera": None,
        "specified": "1", "here": "2", "reason": "It is.",
    }  # fmt: skip
    return plain | special_samples(folder, task, numbers, first)


def special_samples(folder: Path, task: TaskEnvironment, numbers: Iterator[int], first: Path) -> dict[str, object]:
    """Return good arguments of single doors, `door.argument`."""
    library = Path(tasks.__file__).parent / "library"
    new = Fresh(lambda: folder / f"new{next(numbers)}")
    film = Fresh(lambda: folder / f"film{next(numbers)}.mp4")
    extra, kind = ExtraCamera(pose=np.array([0.0, 0, 1, 0, 0, 0, 1])), type(task.task)
    special: dict[str, object] = {
        "read_scene.path": library / "reach_target.toml",
        "read_scene_text.path": library / "reach_target.toml",
        "read_scene_text.text": (library / "reach_target.toml").read_text(encoding="utf-8"),
        "resolve_asset.source": library / "reach_target.toml",
        "gym_id.mode": "state",
        "episode_steps.robot": "panda",
        "VideoWriter.path": film,
        "write_whole.path": new,
        "write_demo.path": new,
        "keep_files.root": new,
        "TrialJournal.path": new,
        "DatasetWriter.root": new,
        "key_frames.demo": make_demo(),
        "is_task_file.task": kind,
        "camel_case.name": "x_y",
        "checked_class.task": kind,
        "stored_demos.random_selection": False,
        "load_task_file.path": library / "reach_target.py",
        "ObservationConfig.camera.name": "front",
    }
    special |= {
        "ObservationConfig.add_camera.name": Fresh(lambda: f"extra{next(numbers)}"),
        "ObservationConfig.add_camera.camera": extra,
    }
    special |= {f"{name}.task": kind for name in ("keep_task", "task_digest", "task_reference", "task_scene")}
    special |= {f"{name}.task": task for name in ("VideoRecorder", "convert_by_playing", "replay_demo", "verify")}
    special |= {"expert_action.task_environment": task, "expert_action.action_mode": None}
    special |= {"keep_tasks.tasks": [kind], "keep_tasks.root": new, "keep_task.root": new}
    return special | more_samples(library, new, first) | evaluation_samples(folder, numbers)


def evaluation_samples(folder: Path, numbers: Iterator[int]) -> dict[str, object]:
    """Return those of results of evaluations and of sets of tasks."""
    made = results({"reach_target": "10", "open_drawer": "11"})
    summary = evaluation.summarise(made, np.random.default_rng(0))
    record = made.episodes[0]
    fields = {f"EpisodeRecord.{name}": value for name, value in vars(record).items()}
    fields |= {f"Results.{name}": getattr(made, name) for name in inspect.signature(evaluation.Results).parameters}
    return fields | {
        "read_results.path": evaluation.write_results(folder / "results.json", made),
        "write_results.path": Fresh(lambda: folder / f"results{next(numbers)}.json"),
        "write_results.results": made,
        "results_text.results": made,
        "summarise.results": made,
        "compare.first": made,
        "compare.second": made,
        "compare.measure": "stable",
        "comparison_table.comparison": evaluation.compare(made, made, np.random.default_rng(0)),
        "task_table.summary": summary,
        "overview_table.summaries": [summary],
        "draw_results.summaries": [summary],
        "draw_results.path": Fresh(lambda: folder / f"plot{next(numbers)}.svg"),
        "mean_rate.rates": [],
        "mean_rate.draws": 10,
        "holm.p_values": [0.1],
        "mcnemar.only_first": 3,
        "mcnemar.only_second": 4,
        **{f"{name}.{rate}": value for name in ("paired_power", "episodes_needed") for rate, value in RATES.items()},
        "paired_power.episodes": 25,
        "episodes_needed.power": 0.3,
        "width_note.episodes": 25,
        "task_set.name": "FS10_V1",
    }


def policy_samples() -> dict[str, object]:
    """Return those of doors about policies."""
    return {
        "ChallengeConfig.learner": "nearest",
        "find_learner.reference": "nearest",
        "find_exporter.name": "robomimic",
        "find_policy.reference": "noop",
        "learning_curve.learner": "nearest",
        "learning_curve.split": "V1",
        "learning_curve.results": {},
        "meta_split.name": "V1",
        "open_policy.reference": "noop",
        "FunctionPolicy.function": lambda observation: observation,
        "KeyFrame.is_open": True,
        "PolicySettings.action_mode": {"mode": "JointPositionActionMode"},
    }


def protocol_samples() -> dict[str, object]:
    """Return those of doors of protocols: one episode of one task."""
    content: dict[str, object] = {
        "name": "one", "version": 1, "cameras": ("front",), "image_size": (16, 16), "arm": "JointPosition", "gripper": "Discrete",
        "max_steps": 1, "max_seconds": 1.0, "episodes_of": "task", "tasks": (evaluation.ProtocolTask("reach_target", (0,)),),
        "splits": {"test": evaluation.Split(1)},
    }  # fmt: skip
    protocol = evaluation.Protocol(**content)  # type: ignore[arg-type]
    seed = evaluation.evaluation_seed(0, 0)
    episode = evaluation.EpisodeRecord("reach_target", 0, seed, success=False, lasts=False, steps=1, seconds=0.1, end="steps")
    results = evaluation.Results("noop", {}, "one", ("reach_target",), (seed,), {}, {}, "", (episode,), "key", protocol=protocol)
    return {
        **{f"Protocol.{name}": value for name, value in content.items()},
        "ProtocolTask.variations": (0,),
        "Split.episodes": 1,
        "load_protocol.name": "peract18",
        "load_mapping.name": "libero",
        "summarise_protocol.results": results,
        "protocol_table.summary": evaluation.summarise_protocol(results),
        "verify_results.results": results,
        "verify_results.share": 1.0,
        "check_comparable.results": [results, results],
        "check_comparable.labels": ["one", "two"],
    }


def more_samples(library: Path, new: Fresh, first: Path) -> dict[str, object]:
    """Return those of doors that read and write single files, draw colours, or turn poses."""
    return {
        "counted_demo.path": first,
        "counted_demo.fields": ["front_rgb"],
        "replay_stored.paths": [first],
        "EpisodeRunner.config": SMALL,
        "EvaluationConfig.policy": "noop",
        "evaluation_seed.seed": 0,
        "evaluation_seed.index": 0,
        "plan_episodes.config": SMALL,
        "write_seeds.path": new,
        "write_seeds.seeds": [],
        "write_scene.path": new,
        "write_scene.spec": scene.read_scene(library / "reach_target.toml"),
        "make_environment.config": low_dim_config(),
        "export_dataset.name": "rlbench",
        "image_config.image_size": (16, 16),
        "calculate_delta_pose.current": np.array([0.0, 0, 1, 0, 0, 0, 1]),
        "distractor_colors.goal": 0,
        "calculate_delta_pose.action": np.array([0.0, 0, 0.1, 0, 0, 0, 1]),
        "distractor_colors.count": 2,
        "fill_up_colors.asked": [],
        "fill_up_colors.count": 2,
        "fill_up_colors.palette": tasks.COLORS,
        **policy_samples(),
        **protocol_samples(),
        "Episode.array.field": "joint_positions",
        "Episode.series.field": "joint_positions",
        "Episode.misc.key": "scalar",
        "Episode.shape.field": "joint_positions",
        "TaskEnvironment.set_variation.v": 0,
        "TaskEnvironment.set_factors.factors": "friction:1",
        "SceneSpec.format": 2,
        "HistorySpec.version": 2,
        "HistorySpec.change": "It is.",
        "SensorSpec.shape": "box",
        "Tray.half": np.array([0.1, 0.1]),
        **{f"{record}.size": (0.1, 0.1, 0.1) for record in ("SensorSpec", "RegionSpec")},
        **{f"{record}.pose": np.array([0.0, 0, 1, 0, 0, 0, 1]) for record in RECORDS},
    }


def _public(module: ModuleType, good: dict[str, object]) -> Iterator[Door]:
    """Yield the doors of a module that take arguments."""
    for name in module.__all__:
        thing = getattr(module, name)
        is_protocol = getattr(thing, "_is_protocol", False)
        is_error = inspect.isclass(thing) and issubclass(thing, BaseException)
        if name in SKIPPED or is_protocol or is_error or not (inspect.isfunction(thing) or inspect.isclass(thing)):
            continue
        (door,) = functions(module, [name], good, LOOSE)
        if parameters_of(thing):
            yield door


def data_doors(folder: Path, task: TaskEnvironment) -> list[Door]:
    """Return all of them."""
    good = samples(folder, task)
    modules = (datasets, formats, scene, recording, evaluation, checking, tasks, gym, environment)
    doors = [door for module in modules for door in _public(module, good)]
    doors = [replace(door, good_is_taken=door.name not in PLAYED) for door in doors]
    doors += functions(observation, ["Demo"], good, LOOSE)
    things = (low_dim_config(), datasets.DatasetWriter(folder / "data"), datasets.Episode(good["path"]), task)  # type: ignore[arg-type]
    found = [door for thing in things for door in methods(thing, good, LOOSE, skip=LONG)]
    return doors + [replace(door, finite=not door.name.startswith("Episode.")) for door in found]
