"""What the two texts of a task say, read once for each pair of texts."""

from __future__ import annotations

from functools import cached_property

from rlbench_pin.builder.document.behaviour import Behaviour
from rlbench_pin.builder.document.errors import EditRefused, TaskFilesError
from rlbench_pin.builder.document.history import Texts
from rlbench_pin.builder.document.problems import python_problems, scene_problem
from rlbench_pin.builder.document.python_text.source import PythonSyntaxError, Source
from rlbench_pin.builder.document.scene_text.scene_text import SceneText
from rlbench_pin.builder.document.storage import Pair
from rlbench_pin.errors import InvalidValue, RlbenchPinError, SceneFileError
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.reader import scene_from_raw
from rlbench_pin.values import as_text
from rlbench_pin.viewer.recording import Problem


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
        self._scene: SceneText | None = None
        if before is not None and before.texts[0] == texts[0]:
            self.error, self._scene = before.error, before.parsed
            return
        try:
            self._scene = SceneText(texts[0], pair.files[0])
            self.spec = scene_from_raw(self._scene.raw, pair.files[0])
        except RlbenchPinError as error:
            self.error = error

    @property
    def scene(self) -> SceneText:
        """The scene with the places of its parts.

        Raises:
            EditRefused: It is not valid TOML.
        """
        if self._scene is None:
            problem = self.error.problem if isinstance(self.error, SceneFileError) else str(self.error)
            raise EditRefused("edit the scene", problem, "Mend the text first.")
        return self._scene

    @property
    def parsed(self) -> SceneText | None:
        """The same, None when it is not valid TOML."""
        return self._scene

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


def typed(text: str, what: str, saved: bytes | None) -> str:
    """Return a text that somebody has typed, its lines ended as those of the file are in memory, or raise InvalidValue.

    Args:
        text: The text.
        what: What it is called.
        saved: What the file says on disk.
    """
    try:
        as_text(text, what).encode()
    except UnicodeEncodeError as error:
        raise InvalidValue(what, text, f"has to be text that can be written in UTF-8, not {error.reason}") from error
    return text.replace("\r\n", "\n") if saved is None or ends_lines_with_return(saved) else text


def ends_lines_with_return(content: bytes | None) -> bool:
    """Whether every line of a file ends with a carriage return and a line feed."""
    return content is not None and 0 < content.count(b"\n") == content.count(b"\r\n") == content.count(b"\r")


def encoded_pair(texts: Texts, saved: tuple[bytes | None, bytes | None]) -> tuple[bytes, bytes]:
    """Return both files as they would be written, their lines ended as they are on disk."""
    ends = [ends_lines_with_return(content) for content in saved]
    return encoded(texts[0], with_return=ends[0]), encoded(texts[1], with_return=ends[1])
