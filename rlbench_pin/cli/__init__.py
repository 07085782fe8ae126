"""`rlbench-pin <command>`: a frozen dataclass of arguments per command, and a class that works. Results go to stdout, progress and errors to stderr."""
