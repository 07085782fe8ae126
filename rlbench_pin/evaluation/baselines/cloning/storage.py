"""Networks on disk: tensors as safetensors, what they mean as JSON. Nothing is pickled."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load, save

from rlbench_pin.datasets import write_whole
from rlbench_pin.errors import RlbenchPinError

MODEL, SETTINGS, CHECKPOINT = "model.safetensors", "settings.json", "checkpoint.safetensors"
FORMAT = 1


class ModelFileError(RlbenchPinError):
    """A trained model is missing, damaged, or of another kind; names the file and what makes one."""

    def __init__(self, path: Path, why: str) -> None:
        self.path = path
        super().__init__(f"'{path}' {why}. `rlbench-pin train` makes a folder with models.")


def write_tensors(path: Path, tensors: Mapping[str, torch.Tensor], **notes: str) -> None:
    """Write tensors and a few texts as one file, whole or not at all."""
    plain = {name: tensor.detach().to("cpu").contiguous() for name, tensor in tensors.items()}
    write_whole(path, save(plain, metadata=notes))


def read_tensors(path: Path) -> tuple[dict[str, torch.Tensor], dict[str, str]]:
    """Return the tensors and texts of a file.

    Raises:
        ModelFileError: It is missing or damaged.
    """
    if not path.is_file():
        raise ModelFileError(path, "does not exist")
    try:
        with safe_open(path, framework="pt") as file:
            notes = dict(file.metadata() or {})
        return load(path.read_bytes()), notes
    except (SafetensorError, OSError) as error:
        raise ModelFileError(path, f"is damaged ({error})") from error


def write_settings(path: Path, kind: str, settings: Mapping[str, Any]) -> None:
    """Write what a model is and how it was made, as JSON."""
    content = {"format": FORMAT, "kind": kind, **settings}
    write_whole(path, (json.dumps(content, indent=1, sort_keys=True) + "\n").encode())


def read_settings(path: Path, kind: str) -> dict[str, Any]:
    """Return what `write_settings` wrote.

    Raises:
        ModelFileError: The file is missing, damaged, or about another kind of model.
    """
    if not path.is_file():
        raise ModelFileError(path, "does not exist")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        raise ModelFileError(path, f"is damaged ({error})") from error
    if not isinstance(content, dict) or (content.pop("format", None), content.pop("kind", None)) != (FORMAT, kind):
        raise ModelFileError(path, f"is not about a model of kind '{kind}'")
    return content


def fill_network(network: torch.nn.Module, path: Path) -> None:
    """Load the tensors of a file into a network.

    Raises:
        ModelFileError: It is missing, damaged, or of another network.
    """
    tensors, _ = read_tensors(path)
    try:
        network.load_state_dict(tensors)
    except RuntimeError as error:
        raise ModelFileError(path, "does not fit the settings beside it") from error


def trained_tasks(folder: Path, kind: str) -> dict[str, dict[str, Any]]:
    """Return the settings of the models in a folder by task, each in a folder of its own.

    Raises:
        ModelFileError: There is none.
    """
    found = {p.parent.name: read_settings(p, kind) for p in sorted(Path(folder).glob(f"*/{SETTINGS}"))}
    if not found:
        raise ModelFileError(Path(folder), f"holds no model of kind '{kind}'")
    return found
