"""The validator: it measures whether tasks fulfil their contract, and writes reports.

`__init__.pyi` lists the names. Each is imported at its first use, so that the help of the command line needs no simulator.
"""

import lazy_loader as lazy

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)
