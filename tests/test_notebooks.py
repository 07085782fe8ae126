"""The code cells of the notebooks run in their order, and outputs are not committed."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
SAYS = {"first_episode": "reward 1.0 ended True", "plan_and_control": "certified: True", "dataset_to_policy": "solved 5 of 5"}
"""Output of each notebook that reaches its goal."""


def cells(notebook: Path, kind: str) -> list[dict[str, Any]]:
    """Return the cells of a kind, `code` or `markdown`."""
    return [cell for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == kind]


def test_each_notebook_has_a_goal() -> None:
    """Every notebook is named with what it prints."""
    assert [notebook.stem for notebook in NOTEBOOKS] == sorted(SAYS)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_outputs_are_not_committed(notebook: Path) -> None:
    """Cells have neither outputs nor numbers of execution."""
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells(notebook, "code"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_links_lead_to_pages(notebook: Path) -> None:
    """Every relative link exists."""
    text = "".join("".join(cell["source"]) for cell in cells(notebook, "markdown"))
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    assert links and all((notebook.parent / link).is_file() for link in links)


@pytest.mark.simulation
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_the_cells_run(notebook: Path, tmp_path: Path) -> None:
    """In their order, in a folder of their own, without a display."""
    program = tmp_path / f"{notebook.stem}.py"
    program.write_text("\n".join("".join(cell["source"]) for cell in cells(notebook, "code")), encoding="utf-8")
    environment = {"MPLBACKEND": "agg", "PYTHONPATH": str(ROOT), "PATH": "", "OMP_NUM_THREADS": "1"}
    result = subprocess.run(
        [sys.executable, str(program)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600
    )
    assert result.returncode == 0, result.stderr
    assert SAYS[notebook.stem] in result.stdout
