"""An environment for LeRobot's environment hub: upload this file and `requirements.txt` to a repository of the hub.

`lerobot.envs.factory.make_env("you/your-repository", n_envs=4, trust_remote_code=True)` then calls `make_env` below. The
environment variable RLBENCH_PIN_TASKS contains the tasks, separated by commas; the default is all tasks.
"""

from rlbench_pin.gym import make_env

__all__ = ["make_env"]
