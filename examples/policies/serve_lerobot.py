"""Serve a LeRobot checkpoint from the Python environment of LeRobot: `python serve_lerobot.py FOLDER unix:/tmp/policy.sock`.

That environment needs `pip install msgpack`; `policy_server.py` and `lerobot_directory.py` of rlbench_pin are next to this file.
FOLDER is `pretrained_model` of a checkpoint, trained on an export of `rlbench-pin dataset export lerobot`.

What to look for: the checkpoint defines the cameras and the image size.
"""

from __future__ import annotations

import sys

from lerobot_directory import LeRobotPolicy
from policy_server import serve

if __name__ == "__main__":
    serve(lambda: LeRobotPolicy(sys.argv[1]), sys.argv[2])
