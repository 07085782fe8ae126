"""Arms and hands, as views on the robot of the running world."""
