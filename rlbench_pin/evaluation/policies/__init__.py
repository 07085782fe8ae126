"""Policies: what acts on observations, and how it is reached, in this process, in one of its own or over a socket."""
