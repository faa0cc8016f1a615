"""Plan a run, start workers, time calls of methods, and keep the results in a record."""
