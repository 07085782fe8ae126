"""What learners are not given of test tasks: it is refused when they ask for it, and cut off what is sent."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rlbench_pin.evaluation.policies.policy import PolicyContext, PolicySettingsError
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import encode_observation
from rlbench_pin.observation import FIELDS as DECLARED
from rlbench_pin.observation import Observation

FIELDS = ("task_low_dim_state", "ignore_collisions")
"""Fields of observations that no learner is given."""
MISC = ("mask_names", "world_distances")
"""Likewise, entries of `misc` beside those that no policy is given."""
_PICTURES = ("_rgb", "_depth", "_point_cloud")


def check_settings(settings: PolicySettings) -> PolicySettings:
    """Return the settings of a learner.

    Raises:
        PolicySettingsError: It asks for what the challenge withholds.
    """
    seen = settings.make_obs_config()
    cameras = {**seen.cameras(), **{name: extra.config for name, extra in seen.extra_cameras.items()}}
    asked = [name for name, camera in cameras.items() if camera.mask]
    what = f"masks ({asked[0]})" if asked else ""
    what = "task_low_dim_state" if seen.task_low_dim_state else what
    what = "model.world_distances" if seen.model.world_distances else what
    if what:
        hint = "The challenge gives pictures, depth, point clouds and what the arm measures."
        raise PolicySettingsError("What a learner observes", what, "is withheld in the challenge", hint)
    return settings


def shown(observation: Observation, *, pictures: bool = True) -> dict[str, Any]:
    """Return what a learner is given of an observation of a test task, as a map.

    Args:
        observation: All of it.
        pictures: Whether pictures are among it.
    """
    sent = encode_observation(observation)
    cut = {name: value for name, value in sent.items() if name not in FIELDS and not name.endswith("_mask") and name != "misc"}
    if not pictures:
        cut = {name: value for name, value in cut.items() if not name.endswith(_PICTURES)}
    misc: Mapping[str, Any] = sent["misc"]
    return {**cut, "misc": {name: value for name, value in misc.items() if name not in MISC}}


def leave_pictures_out(observation: Observation) -> None:
    """Take the pictures out of an observation."""
    for name in [name for name in vars(observation) if name.endswith(_PICTURES)]:
        if name in DECLARED:
            setattr(observation, name, None)
        else:
            delattr(observation, name)


def shown_context(context: PolicyContext, seed: int) -> PolicyContext:
    """Return what a policy of a learner is told: without the task, and with a seed that is the same for all episodes.

    A seed for each episode would be a hash of its task and number, which whoever knows all names could find by trying them.

    Args:
        context: What policies are told otherwise.
        seed: Seed of the run.
    """
    digest = hashlib.sha256(f"rlbench_pin challenge policy/{seed}".encode()).digest()
    return replace(context, task="", seed=int.from_bytes(digest[:8], "big") >> 11)
