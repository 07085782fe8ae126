"""What stands behind the tasks of `rlbench`: names and sets, and users' classes run as tasks of ours."""
