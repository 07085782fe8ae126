"""Environments shared by the tests of this folder."""

from tests.environment.conftest import reach

__all__ = ["reach"]
