"""Memory that closed worlds leave behind."""

from __future__ import annotations

import ctypes
import gc

_TRIM = getattr(ctypes.CDLL(None), "malloc_trim", None)
"""Hands free memory back to the system; only glibc has it."""


def give_back_memory(*, collect: bool = False) -> None:
    """Give memory that is not used back to the system.

    The C library keeps what a physics server has freed, some 30 MB for each closed world, until it is asked for.

    Args:
        collect: Look for unreachable Python objects first.
    """
    if collect:
        gc.collect()
    if _TRIM is not None:
        _TRIM(0)
