"""Modules below environments and tasks; `exceptions` and `observation` are names of modules of rlbench_pin."""

import sys

import rlbench_pin.errors as exceptions
import rlbench_pin.observation as observation

sys.modules.update({f"{__name__}.exceptions": exceptions, f"{__name__}.observation": observation})
