"""The tested versions: every library that `make` installs is pinned, within what pyproject.toml allows."""

from __future__ import annotations

import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
WANTED = [Requirement(line) for line in (*PROJECT["dependencies"], *EXTRAS["dev"], *EXTRAS["bench"])]
PINS = {
    canonicalize_name(pin.name): pin
    for pin in map(Requirement, (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines())
}
VERSIONS = {name: str(pin.specifier).removeprefix("==") for name, pin in PINS.items()}


@pytest.mark.parametrize("wanted", WANTED, ids=lambda r: r.name)
def test_every_requirement_is_pinned_within_its_range(wanted: Requirement) -> None:
    """`make lock` writes the pins; a changed range asks for new ones. Pin and requirement are for the same versions of Python."""
    name = canonicalize_name(wanted.name)
    assert wanted.specifier.contains(VERSIONS[name], prereleases=True)
    assert PINS[name].marker == wanted.marker


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13"])
def test_every_python_has_one_pybullet(python: str) -> None:
    """Two distributions have the module `pybullet`; each supported Python gets one of them."""
    names = {r.name for r in WANTED if r.marker is not None and r.marker.evaluate({"python_version": python})}
    assert names == ({"pybullet"} if python == "3.11" else {"pybullet-arm64"})
    assert f"Programming Language :: Python :: {python}" in PROJECT["classifiers"]
    assert SpecifierSet(PROJECT["requires-python"]).contains(f"{python}.1")


def test_what_is_installed_by_make_is_what_is_pinned() -> None:
    """The environment of `make` has the pinned versions; one made otherwise is not asked."""
    if Path(sys.prefix) != ROOT / ".venv":
        pytest.skip("this environment was not made by `make`")
    installed = {canonicalize_name(d.metadata["Name"]): d.version for d in metadata.distributions()}
    assert {n: v for n, v in installed.items() if n in VERSIONS and VERSIONS[n] != v} == {}


def test_make_and_continuous_integration_install_with_the_pins() -> None:
    """The one recipe that installs takes the constraints, and `.ci/run` goes through it."""
    assert "-c constraints.txt -e" in (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "make test" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_the_hooks_of_pre_commit_have_the_pinned_linter() -> None:
    """`make lint` and the hooks run one version of ruff."""
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"]
    assert [hook["rev"] for hook in hooks] == [f"v{VERSIONS['ruff']}"]
