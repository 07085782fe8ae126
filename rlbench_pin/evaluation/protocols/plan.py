"""The episodes of a protocol, and the check of a policy against it."""

from __future__ import annotations

from rlbench_pin.environment.episode import drawn_variations
from rlbench_pin.evaluation.policies.references import EXPERT, IN_PROCESS
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.protocols.protocol import TASK, Protocol, ProtocolConflict

Place = tuple[int, int, int]
"""Variation, seed of the split, and number of the episode for that seed."""


def split_places(protocol: Protocol, split: str) -> dict[str, list[Place]]:
    """Return the episodes of a split for each task of the selected part.

    Args:
        protocol: The protocol.
        split: `train`, `validation` or `test`.

    Raises:
        UnknownName: The protocol has no such split.
        ProtocolConflict: The split has another part than the selected one.
    """
    protocol, chosen = protocol.for_split(split), protocol.split(split)
    found: dict[str, list[Place]] = {name: [] for name in protocol.task_names}
    for seed in chosen.seeds:
        for task in protocol.selected:
            numbers = range(chosen.episodes)
            if protocol.episodes_of == TASK:
                drawn = [task.variations[i] for i in drawn_variations(len(task.variations), chosen.episodes)]
                found[task.name] += [(drawn[number % len(drawn)], seed, number) for number in numbers]
            else:
                found[task.name] += [(variation, seed, number) for variation in task.variations for number in numbers]
    return found


def check_policy(protocol: Protocol, policy: str, settings: PolicySettings) -> None:
    """Check the settings of a policy against a protocol. Every protocol allows the policies `noop`, `random` and `expert`.

    Args:
        protocol: The protocol.
        policy: Reference of the policy.
        settings: Settings of the policy; it may use fewer cameras than the protocol.

    Raises:
        ProtocolConflict: The policy has another action mode, other cameras or another image size.
    """
    if policy.partition("?")[0] in (*IN_PROCESS, EXPERT):
        return
    advice = f"Change the policy '{policy}', or use your own protocol file."
    for part in ("arm", "gripper"):
        if (asked := settings.action_mode.get(part, settings.action_mode["mode"])) != (wanted := getattr(protocol, part)):
            raise ProtocolConflict(protocol.label, f"{part} action mode", asked, wanted, advice)
    seen = settings.make_obs_config()
    cameras = {name: camera for name, camera in seen.cameras().items() if camera.is_used}
    if others := [*(name for name in cameras if name not in protocol.cameras), *seen.extra_cameras]:
        raise ProtocolConflict(protocol.label, "cameras", others, protocol.cameras, advice)
    for name, camera in cameras.items():
        if tuple(camera.image_size) != protocol.image_size:
            raise ProtocolConflict(protocol.label, f"image size of {name} [px]", camera.image_size, protocol.image_size, advice)
