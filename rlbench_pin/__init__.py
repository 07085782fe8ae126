"""Robot manipulation tasks with planned demonstrations, on Pinocchio and PyBullet.

The names below are all that most programs need; everything else is a name of one of the packages, such as
`rlbench_pin.planning.MotionPlanner`. Both are looked up when first used, so that importing the package starts nothing and reads
nothing. Where gymnasium is installed, the ids `rlbench_pin/<task>-state-v0` and `-vision-v0` are
registered with it.
"""

from __future__ import annotations

import sys

if sys.argv[:1] == ["-m"] and "rlbench_pin.cli.main" in sys.orig_argv:  # the command line: Ctrl-C is quiet from here on
    from rlbench_pin.cli.interrupts import end_quietly

    end_quietly()

import importlib
import importlib.util
import logging

import lazy_loader as lazy

__version__ = "0.2.0"

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)

logging.getLogger(__name__).addHandler(logging.NullHandler())
if importlib.util.find_spec("gymnasium") is not None:
    importlib.import_module("rlbench_pin.gym")  # registers the ids
