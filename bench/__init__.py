"""The harness: runs every method in its own process, times it, judges it, reports it."""
