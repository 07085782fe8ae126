"""The process around a command: the table of commands, arguments, Ctrl-C, closed pipes, exit codes, and files that it writes."""
