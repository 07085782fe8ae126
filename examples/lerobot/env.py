"""The whole of what LeRobot's environment hub needs: put this file and `requirements.txt` into a repository of the hub.

`lerobot.envs.factory.make_env("you/your-repository", n_envs=4, trust_remote_code=True)` then calls `make_env` below. The
environment variable RLBENCH_PIN_TASKS names the tasks, separated by commas; all of them when it is unset.
"""

from rlbench_pin.gym import make_env

__all__ = ["make_env"]
