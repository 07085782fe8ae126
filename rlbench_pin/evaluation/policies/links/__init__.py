"""Where policies run: in this process, in one of their own, behind a socket."""
