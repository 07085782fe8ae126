"""`rlbench-pin <command>`: the arguments of each are a frozen dataclass. Results go to stdout, progress and errors to stderr."""
