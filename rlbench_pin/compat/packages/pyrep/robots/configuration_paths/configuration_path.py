"""What paths of configurations share."""

from __future__ import annotations


class ConfigurationPath:
    """A path that a robot follows step by step."""

    def step(self) -> bool:
        """Command the next part of the motion; True when it is the last."""
        raise NotImplementedError

    def set_to_start(self, disable_dynamics: bool = False) -> None:
        """Put the robot at the beginning of the path."""
        raise NotImplementedError

    def set_to_end(self, disable_dynamics: bool = False) -> None:
        """Put the robot at the end of the path."""
        raise NotImplementedError

    def visualize(self) -> None:
        """Draw the path."""
        raise NotImplementedError

    def clear_visualization(self) -> None:
        """Remove the drawing."""
        raise NotImplementedError
