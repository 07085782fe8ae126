"""Evaluation of policies on sets of tasks, with statistics, and the few-shot challenge.

`__init__.pyi` lists the names. Each is imported at its first use, so that a list of sets or a table needs no simulator.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
