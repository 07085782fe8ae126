"""XML of unknown origin: no entities, no types of its own, of bounded size and depth; numbers that are numbers."""

from __future__ import annotations

import math
from xml.etree import ElementTree
from xml.parsers import expat

from rlbench_pin.builder.server import UploadRefused

LARGEST_TEXT = 4 * 1024 * 1024
"""Of a URDF file [bytes]."""
_MOST_ELEMENTS = 20_000
_DEEPEST = 32


class _Watch:
    """Counts what a parser meets.

    Args:
        name: Of the file.
    """

    def __init__(self, name: str) -> None:
        self._name, self._depth, self._count = name, 0, 0

    def start(self, tag: str, attributes: object) -> None:
        """An element begins."""
        self._depth, self._count = self._depth + 1, self._count + 1
        if self._depth > _DEEPEST or self._count > _MOST_ELEMENTS:
            problem = f"it has more than {_MOST_ELEMENTS} elements, or more than {_DEEPEST} inside one another"
            raise UploadRefused(self._name, problem)

    def end(self, tag: str) -> None:
        """An element ends."""
        self._depth -= 1

    def declare(self, *said: object) -> None:
        """A document type or an entity is declared."""
        hint = "Remove <!DOCTYPE ...>: a URDF file needs none."
        raise UploadRefused(self._name, "it declares a document type, or entities, which could stand for anything", hint)


def parse_xml(name: str, data: bytes) -> ElementTree.Element:
    """Return the first element of a text.

    Raises:
        UploadRefused: It is no XML, too large, too deep, or declares entities.
    """
    if len(data) > LARGEST_TEXT:
        raise UploadRefused(name, f"it has {len(data) / 2**20:.0f} MB of XML, at most {LARGEST_TEXT // 2**20} MB are taken")
    watch, parser = _Watch(name), expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = watch.start, watch.end
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = watch.declare
    try:
        parser.Parse(data, True)
        return ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, LookupError, ValueError) as error:
        raise UploadRefused(name, f"it is no valid XML: {error}") from error


class Numbers:
    """Reads numbers of elements.

    Args:
        name: Of the file, for errors.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def several(self, element: ElementTree.Element | None, key: str, count: int, default: str) -> tuple[float, ...]:
        """Return so many finite numbers of an attribute."""
        if element is None:
            return tuple(float(word) for word in default.split())
        said = element.get(key, default)
        try:
            numbers = tuple(float(word) for word in said.split())
        except ValueError:
            numbers = ()
        if len(numbers) != count or not all(math.isfinite(number) and abs(number) < 1e6 for number in numbers):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            raise UploadRefused(self._name, f"'{key}' of a <{element.tag}> has to be {wanted}, not '{said[:60]}'")
        return numbers

    def one(self, element: ElementTree.Element | None, key: str, default: str, least: float = -math.inf) -> float:
        """Return one finite number of an attribute, of at least so much."""
        number = self.several(element, key, 1, default)[0]
        if number < least:
            tag = "" if element is None else element.tag
            raise UploadRefused(self._name, f"'{key}' of a <{tag}> is {number:g}, and has to be {least:g} or more")
        return number

    def positive(self, element: ElementTree.Element, key: str, count: int, default: str, most: float) -> tuple[float, ...]:
        """Return numbers of an attribute that are above 0."""
        numbers = self.several(element, key, count, default)
        if not all(0.0 < number <= most for number in numbers):
            said = " ".join(f"{number:g}" for number in numbers)
            raise UploadRefused(self._name, f"'{key}' of a <{element.tag}> is {said}, and has to be above 0, at most {most:g}")
        return numbers
