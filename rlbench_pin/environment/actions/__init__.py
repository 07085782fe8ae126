"""What actions mean: arm modes, gripper modes, and both together."""
