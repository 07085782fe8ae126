"""All tasks as gymnasium environments; importing this package registers the ids.

The environments are imported at their first use, so that registration is fast.
"""

import lazy_loader as lazy

from rlbench_pin.gym.ids import register_ids

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)

register_ids()
