"""The task `place_shape_in_shape_sorter` under its known name."""

from rlbench.backend.task import Task


class PlaceShapeInShapeSorter(Task):
    """The task `place_shape_in_shape_sorter` of our library."""

    library_name = "place_shape_in_shape_sorter"
