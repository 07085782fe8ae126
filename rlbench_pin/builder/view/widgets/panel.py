"""Shows the items of a panel in the browser: what is there stays and takes new values, what differs is made anew."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from viser import GuiApi

from rlbench_pin.builder.view.widgets import makers
from rlbench_pin.builder.view.widgets.items import Fold, Item
from rlbench_pin.builder.view.widgets.makers import Post, Widget

_Shape = tuple[object, ...]


class Container(Protocol):
    """Where items can be put: a folder, a tab, a panel."""

    def __enter__(self) -> object:
        """Have what is made from now on put here."""
        ...

    def __exit__(self, *args: object) -> object:
        """No longer."""
        ...


class Panel:
    """Items below one another.

    Args:
        gui: The page.
        container: Where they are put.
        post: Has a function run where edits are made, one after the other.
    """

    def __init__(self, gui: GuiApi, container: Container, post: Post) -> None:
        self._gui, self._container, self._post = gui, container, post
        self._shown: list[tuple[_Shape, Widget | _Folder]] = []

    def show(self, items: Sequence[Item]) -> None:
        """Make the panel consist of these items."""
        shapes = [makers.shape(item) for item in items]
        same = 0
        while same < min(len(shapes), len(self._shown)) and self._shown[same][0] == shapes[same]:
            same += 1
        for _, widget in reversed(self._shown[same:]):
            widget.remove()
        del self._shown[same:]
        for (_, widget), item in zip(self._shown, items):
            widget.show(item)
        with self._container:
            for shape, item in zip(shapes[same:], items[same:]):
                self._shown.append((shape, self._make(item)))

    def _make(self, item: Item) -> Widget | _Folder:
        return _Folder(self._gui, item, self._post) if isinstance(item, Fold) else makers.make(self._gui, item, self._post)

    def clear(self) -> None:
        """Take everything out."""
        self.show(())


class _Folder:
    """A title with items below it."""

    def __init__(self, gui: GuiApi, fold: Fold, post: Post) -> None:
        self._folder = gui.add_folder(fold.label, expand_by_default=fold.is_open)
        self._panel = Panel(gui, self._folder, post)
        self._panel.show(fold.items)

    def show(self, item: Item) -> None:
        """Have these items below the title."""
        if isinstance(item, Fold):
            self._panel.show(item.items)

    def remove(self) -> None:
        """Take it out."""
        self._folder.remove()


__all__ = ["Container", "Panel"]
