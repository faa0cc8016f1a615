"""A vehicle: its numbers (``model``), their ``geometry``, and the files that hold them."""

from alloc.vehicle.checks import LARGEST
from alloc.vehicle.model import RANK_TOLERANCE, Vehicle

__all__ = ["LARGEST", "RANK_TOLERANCE", "Vehicle"]
