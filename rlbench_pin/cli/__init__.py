"""`rlbench-pin <command>`: one frozen dataclass per command. Results go to stdout, progress and errors to stderr."""
