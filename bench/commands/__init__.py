"""One file, one command: each has ``command``, a click command, and imports what it needs when called."""
