"""Switch a television to the next or the previous channel with its remote control."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, Detected, JointMoved, NothingGrasped, SpawnBoundary, Task

WHITE = (1.0, 1.0, 1.0)
CHANNELS = {
    "one": ((0.12, 0.14, 0.42), (0.34, 0.38, 0.50), (0.95, 0.95, 0.85)),
    "two": ((0.55, 0.80, 1.0), (0.20, 0.55, 0.18), (1.0, 0.85, 0.20)),
    "three": ((1.0, 0.72, 0.40), (0.45, 0.22, 0.30), (1.0, 0.25, 0.15)),
}
"""Link of the digit of each channel -> the colours of sky, hills and sun in the image of the channel."""


class ChangeChannel(Task):
    """The remote must lie in front of the television, point to it, and be released. The requested button must be down by 3 mm."""

    buttons = ("plus", "minus")
    words = (("plus", "up", "three"), ("minus", "down", "one"))

    def init_task(self) -> None:
        """The remote may be grasped by its body; a button counts while the released remote is at its goal place."""
        self.television, self.remote = self.world.body("television"), self.world.body("remote")
        self.patches = SpawnBoundary([self.world.region("left"), self.world.region("right")])
        self.register_graspable_objects(["remote/remote"])
        ends = {"tip": "front", "tail": "rear"}
        aimed = [Detected(self.world.frame(end), self.world.sensor(place)) for end, place in ends.items()]
        self.commands = [
            AllOf([JointMoved(self.world.joint(f"remote/{name}_joint"), 0.003), *aimed, NothingGrasped(self.gripper)])
            for name in self.buttons
        ]

    def variation_count(self) -> int:
        """One for each button."""
        return len(self.buttons)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the remote beside its goal place and show channel two; success is the requested button pressed at this place."""
        self.patches.clear()
        self.patches.sample(self.remote, rng)
        self._show("two")
        self.world.frame("waypoint6").set_parent(f"remote/{self.buttons[variation]}")
        self.register_success_conditions([self.commands[variation]])
        sign, way, channel = self.words[variation]
        return self.make_instructions(sign=sign, way=way, channel=channel)

    def step(self) -> None:
        """Show the channel of the pressed button."""
        for command, channel in zip(self.commands, ("three", "one"), strict=True):
            if command.met():
                self._show(channel)

    def _show(self, channel: str) -> None:
        sky, hills, sun = CHANNELS[channel]
        digits = {digit: WHITE if digit == channel else sky for digit in CHANNELS}
        for link, rgb in {"screen": sky, "hills": hills, "sun": sun, **digits}.items():
            self.television.set_color(rgb, link)
