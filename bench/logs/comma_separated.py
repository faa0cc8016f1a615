"""CSV, the form of ``bench.demand_csv``."""

from bench.demand_csv import read_demands as read

SUFFIXES = (".csv", "")  # "": a pipe, as in <(zcat demands.csv.gz)

__all__ = ["SUFFIXES", "read"]
