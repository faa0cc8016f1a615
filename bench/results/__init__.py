"""Rows, columns, statistics, rankings and sizes, worked out from records; nothing is measured here."""
