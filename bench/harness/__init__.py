"""The harness: plans a run, starts workers, times the calls of methods, and keeps the results in a record."""
