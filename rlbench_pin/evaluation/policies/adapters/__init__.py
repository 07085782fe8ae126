"""Policies of other forms: functions, key frames, Stable-Baselines3, LeRobot; and the two that need no thought."""
