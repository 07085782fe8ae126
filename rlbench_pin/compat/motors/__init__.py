"""Joint motors of the arm and of the hand, as robot components and joints under the known names command them."""

from rlbench_pin.compat.motors.arm import ArmMotors
from rlbench_pin.compat.motors.fingers import FingerMotors
from rlbench_pin.compat.motors.motors import Motors, Numbers

__all__ = ["ArmMotors", "FingerMotors", "Motors", "Numbers"]
