"""The public interface is typed: a typed program that uses it passes `mypy --strict`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CLIENT = ROOT / "tests" / "typed_client.py"


def checked(file: Path) -> subprocess.CompletedProcess[str]:
    """Let mypy check one file against the package, with its strict settings alone."""
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--follow-imports=silent"]
    cache = f"--cache-dir={ROOT / '.mypy_cache' / 'typed_client'}"
    return subprocess.run([*command, cache, str(file)], capture_output=True, text=True, timeout=500, cwd=ROOT)


@pytest.mark.simulation
def test_a_typed_program_passes(tmp_path: Path) -> None:
    """With `assert_type` where a result matters; a wrong argument is found, so the types are not `Any`."""
    done = checked(CLIENT)
    assert done.returncode == 0, done.stdout + done.stderr
    wrong = tmp_path / "wrong_client.py"
    text = CLIENT.read_text(encoding="utf-8")
    assert "task.reset(seed=7)" in text
    wrong.write_text(text.replace("task.reset(seed=7)", 'task.reset(seed="seven")'), encoding="utf-8")
    done = checked(wrong)
    assert done.returncode == 1 and '"reset" of "TaskEnvironment" has incompatible type' in done.stdout, done.stdout
