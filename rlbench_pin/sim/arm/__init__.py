"""The simulated arm and gripper."""
