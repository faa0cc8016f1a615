"""One file, one demand set, found by its name; ``bench.demands`` says what a file holds."""
