"""An interval of cycles, and what stands in the way of one."""

from typing import NamedTuple


class Span(NamedTuple):
    """At least and at most so many cycles."""

    low: int
    high: int


class Unknown(Exception):
    """Nobody has published what this takes."""
