"""Names of files and folders of stored demonstrations."""

from __future__ import annotations

from rlbench_pin.datasets.formats.rlbench import DEPTH_STEPS, DESCRIPTIONS_FILE, LOW_DIM_FILE, VARIATION_FILE

TTT_FILE = "task_design.ttt"
"""Name of the base scene in RLBench; this package does not read it, because table and arm always exist."""

LEFT_SHOULDER_RGB_FOLDER = "left_shoulder_rgb"
LEFT_SHOULDER_DEPTH_FOLDER = "left_shoulder_depth"
LEFT_SHOULDER_MASK_FOLDER = "left_shoulder_mask"
RIGHT_SHOULDER_RGB_FOLDER = "right_shoulder_rgb"
RIGHT_SHOULDER_DEPTH_FOLDER = "right_shoulder_depth"
RIGHT_SHOULDER_MASK_FOLDER = "right_shoulder_mask"
OVERHEAD_RGB_FOLDER = "overhead_rgb"
OVERHEAD_DEPTH_FOLDER = "overhead_depth"
OVERHEAD_MASK_FOLDER = "overhead_mask"
WRIST_RGB_FOLDER = "wrist_rgb"
WRIST_DEPTH_FOLDER = "wrist_depth"
WRIST_MASK_FOLDER = "wrist_mask"
FRONT_RGB_FOLDER = "front_rgb"
FRONT_DEPTH_FOLDER = "front_depth"
FRONT_MASK_FOLDER = "front_mask"

IMAGE_FORMAT = "%d.png"
"""Format of the file name of an image, with the index of the frame."""
DEPTH_SCALE = DEPTH_STEPS
"""Number of steps of stored depth values from 0 to 1."""

EPISODES_FOLDER = "episodes"
EPISODE_FOLDER = "episode%d"
VARIATIONS_FOLDER = "variation%d"
VARIATIONS_ALL_FOLDER = "all_variations"
LOW_DIM_PICKLE = LOW_DIM_FILE
VARIATION_DESCRIPTIONS = DESCRIPTIONS_FILE
VARIATION_NUMBER = VARIATION_FILE
