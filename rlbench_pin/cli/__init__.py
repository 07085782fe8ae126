"""`rlbench-pin <command>`: what each takes is a frozen dataclass. Results go to stdout, progress and errors to stderr."""
