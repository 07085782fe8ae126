"""Switches that say who looks at a thing."""

from __future__ import annotations

from abc import ABC, abstractmethod

from rlbench_pin.compat.things import Element, ObjectTable, physics


class Switches(ABC):
    """Whether collision checks, distances, sensors and cameras look at a thing, or at a thing and all that hangs on it."""

    @property
    @abstractmethod
    def table(self) -> ObjectTable:
        """All things of the present world."""

    @property
    @abstractmethod
    def element(self) -> Element:
        """What it stands for in the world."""

    def flag(self, name: str, default: bool = True) -> bool:
        """Return one of the switches."""
        return bool(self.table.flags.get((self.element, name), default))

    def set_flag(self, name: str, value: bool, model: bool = False) -> None:
        """Set one of the switches, of the whole tree with `model`."""
        tree = self.table.family.tree(self.table.elements(), self.element) if model else []
        for element in (self.element, *tree):
            self.table.flags[element, name] = bool(value)
            if name == "collidable":
                physics.set_obstacle(self.table, element, bool(value))

    def is_collidable(self) -> bool:
        """Whether collision checks and plans look at it."""
        return self.flag("collidable")

    def set_collidable(self, value: bool) -> None:
        """Let collision checks and plans look at it, or not; physics is not changed (see `Shape.set_respondable`)."""
        self.set_flag("collidable", value)

    def is_measurable(self) -> bool:
        """Whether distances to it are measured."""
        return self.flag("measurable")

    def set_measurable(self, value: bool) -> None:
        """Say whether distances to it are measured."""
        self.set_flag("measurable", value)

    def is_detectable(self) -> bool:
        """Whether proximity sensors see it."""
        return self.flag("detectable")

    def set_detectable(self, value: bool) -> None:
        """Say whether proximity sensors see it."""
        self.set_flag("detectable", value)

    def is_renderable(self) -> bool:
        """Whether cameras see it."""
        return self.flag("renderable")

    def set_renderable(self, value: bool) -> None:
        """Say whether cameras see it; shapes that are not are hidden."""
        self.set_flag("renderable", value)

    # Whole models ----------------------------------------------------------------------------------------------------

    def is_model_collidable(self) -> bool:
        """Whether collision checks look at it and at all that hangs on it."""
        return self._all("collidable")

    def set_model_collidable(self, value: bool) -> None:
        """Let collision checks look at it and at all that hangs on it, or not."""
        self.set_flag("collidable", value, model=True)

    def is_model_measurable(self) -> bool:
        """Whether distances to it and to all that hangs on it are measured."""
        return self._all("measurable")

    def set_model_measurable(self, value: bool) -> None:
        """Say whether distances to it and to all that hangs on it are measured."""
        self.set_flag("measurable", value, model=True)

    def is_model_detectable(self) -> bool:
        """Whether proximity sensors see it and all that hangs on it."""
        return self._all("detectable")

    def set_model_detectable(self, value: bool) -> None:
        """Say whether proximity sensors see it and all that hangs on it."""
        self.set_flag("detectable", value, model=True)

    def is_model_renderable(self) -> bool:
        """Whether cameras see it and all that hangs on it."""
        return self._all("renderable")

    def is_respondable(self) -> bool:
        """Return False: only shapes touch other things."""
        return False

    def set_respondable(self, value: bool) -> None:
        """Remember the switch: only shapes touch other things."""
        self.set_flag("respondable", value)

    def is_dynamic(self) -> bool:
        """Return False: only shapes are moved by physics."""
        return False

    def _all(self, name: str) -> bool:
        tree = self.table.family.tree(self.table.elements(), self.element)
        return all(bool(self.table.flags.get((element, name), True)) for element in (self.element, *tree))
