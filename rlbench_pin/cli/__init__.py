"""`rlbench-pin <command>`: one frozen dataclass per command. Results go to stdout, progress and complaints to stderr."""
