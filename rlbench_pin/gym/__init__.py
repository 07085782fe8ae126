"""Every task as a gymnasium environment; importing this package registers the ids.

The environments themselves are imported when first used, so that registering stays light.
"""

import lazy_loader as lazy

from rlbench_pin.gym.ids import register_ids

__getattr__, __dir__, __all__ = lazy.attach_stub(__name__, __file__)

register_ids()
