"""What the two texts of a task say, read once for each pair of texts."""

from __future__ import annotations

from functools import cached_property

from rlbench_pin.builder.contracts import Problem
from rlbench_pin.builder.document.behaviour import Behaviour
from rlbench_pin.builder.document.behaviour.source import PythonSyntaxError, Source
from rlbench_pin.builder.document.errors import EditRefused, TaskFilesError
from rlbench_pin.builder.document.history import Texts
from rlbench_pin.builder.document.problems import python_problems, scene_problem
from rlbench_pin.builder.document.scene_text.scene_text import SceneText
from rlbench_pin.builder.document.storage import Pair
from rlbench_pin.errors import RlbenchPinError, SceneFileError
from rlbench_pin.scene import SceneSpec, read_scene_text


class Reading:
    """What a pair of texts says.

    Args:
        pair: Where the files lie.
        texts: Scene and Python.
        before: What the texts before them said; parts that did not change are not read again.
    """

    def __init__(self, pair: Pair, texts: Texts, before: Reading | None = None) -> None:
        self.pair, self.texts = pair, texts
        self.error: RlbenchPinError | None = None
        """Why the scene is not valid, None when it is."""
        self.spec: SceneSpec | None = None if before is None else before.spec
        """The scene as the last valid text says it."""
        if before is not None and before.texts[0] == texts[0]:
            self.error = before.error
            return
        try:
            self.spec = read_scene_text(texts[0], pair.files[0])
        except RlbenchPinError as error:
            self.error = error

    @cached_property
    def scene(self) -> SceneText:
        """The scene with the places of its parts.

        Raises:
            EditRefused: It is not valid TOML.
        """
        try:
            return SceneText(self.texts[0], self.pair.files[0])
        except SceneFileError as error:
            raise EditRefused("edit the scene", error.problem, "Mend the text first.") from error

    @cached_property
    def problems(self) -> tuple[Problem, ...]:
        """What is wrong, the scene first."""
        found = () if self.error is None else (scene_problem(self.texts[0], self.error),)
        try:
            source = Source(self.texts[1])
        except PythonSyntaxError as error:
            return (*found, Problem("task", error.line, f"This is no Python: {error.problem}."))
        return (*found, *python_problems(source, self.pair.name, None if self.error is not None else self.spec))

    @cached_property
    def behaviour(self) -> Behaviour:
        """What forms can edit of the Python."""
        return Behaviour.of(self.texts[1])


def decoded(pair: Pair, contents: tuple[bytes, bytes]) -> Texts:
    """Return the texts of both files, lines ended by a line feed alone.

    Raises:
        TaskFilesError: One of them is no text in UTF-8.
    """
    texts = []
    for path, content in zip(pair.files, contents, strict=True):
        try:
            text = content.decode()
        except UnicodeDecodeError as error:
            raise TaskFilesError(path, f"it is no text in UTF-8: {error.reason} at byte {error.start}.") from error
        texts.append(text.replace("\r\n", "\n") if ends_lines_with_return(content) else text)
    return texts[0], texts[1]


def encoded(text: str, *, with_return: bool) -> bytes:
    """Return what a file says, its lines ended as they were."""
    return (text.replace("\n", "\r\n") if with_return else text).encode()


def ends_lines_with_return(content: bytes | None) -> bool:
    """Whether every line of a file ends with a carriage return and a line feed."""
    return content is not None and 0 < content.count(b"\n") == content.count(b"\r\n") == content.count(b"\r")
