"""Demand sets, one a file and named after it; ``bench.demands`` says what such a file holds."""
