"""The results file: JSON, an episode per line, checked when it is read."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

from rlbench_pin.datasets.manifest import parse_json, short
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import ResultsFileError, UnknownName
from rlbench_pin.evaluation.results.records import FORMAT, HEAD, EpisodeRecord, Results
from rlbench_pin.values import as_path, as_record

LARGEST = 256 << 20
"""Larger files are not read [bytes]: a million episodes."""
_EPISODE = tuple(field.name for field in fields(EpisodeRecord))


def results_text(results: Results) -> str:
    """Return the text of a results file."""
    content = as_record(results, Results, "results").content()
    lines = ",\n".join(json.dumps(episode, allow_nan=False) for episode in content.pop("episodes"))
    head = json.dumps({**content, "sha256": results.sha256}, indent=1, allow_nan=False)
    return f'{head[:-2]},\n "episodes": [\n{lines}\n ]\n}}\n'


def write_results(path: Path | str, results: Results) -> Path:
    """Write a results file; it appears whole or not at all.

    Raises:
        StorageError: The disk cannot be written to.
    """
    return write_whole(as_path(path, "path"), results_text(results).encode())


def read_results(path: Path | str) -> Results:
    """Return what a results file says.

    Raises:
        ResultsFileError: It is missing, too large, no results file, of another format, or altered since it was written.
    """
    path = as_path(path, "path")
    try:
        if not path.is_file():
            raise ValueError("there is no such file")
        if (size := path.stat().st_size) > LARGEST:
            raise ValueError(f"it has {size} bytes, more than {LARGEST}")
        return _results(parse_json(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, UnknownName) as error:
        raise ResultsFileError(path, str(error).rstrip(".")) from error


def _results(content: object) -> Results:
    """Return results from plain data.

    Raises:
        ValueError: A value is missing, unknown or wrong, or the checksum is another.
    """
    if not isinstance(content, dict):
        raise ValueError("it is no table")
    if (found := content.get("format")) != FORMAT or type(found) is not int:
        raise ValueError(f"it has format {short(found)}, this package reads format {FORMAT}")
    _check_names(content, ("format", *HEAD, "sha256", "episodes"), "it")
    if not isinstance(content["episodes"], list):
        raise ValueError("its episodes are no list")
    results = Results(**{name: content[name] for name in HEAD}, episodes=tuple(map(_episode, content["episodes"])))
    if content["sha256"] != results.sha256:
        raise ValueError(f"it was altered: its content has sha256 {results.sha256}, not {short(content['sha256'])}")
    return results


def _episode(content: Any) -> EpisodeRecord:
    if not isinstance(content, dict):
        raise ValueError(f"an episode is {short(content)}, no table")
    _check_names(content, _EPISODE, "an episode")
    return EpisodeRecord(**content)


def _check_names(content: dict[str, Any], names: tuple[str, ...], what: str) -> None:
    """Raise ValueError unless a table has just these names."""
    if missing := [name for name in names if name not in content]:
        raise ValueError(f"{what} lacks {', '.join(missing)}")
    if unknown := [name for name in content if name not in names]:
        raise ValueError(f"{what} has {short(unknown[0])}, which this format does not know")


__all__ = ["read_results", "results_text", "write_results"]
