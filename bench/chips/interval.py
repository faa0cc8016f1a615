"""An interval of cycles, and the error where none is published."""

from typing import NamedTuple


class Cycles(NamedTuple):
    """At least and at most so many cycles."""

    low: int
    high: int


class Unpublished(Exception):
    """Nobody has published what this takes."""
