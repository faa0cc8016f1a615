"""A vehicle: its numbers (``model``), their ``geometry``, and the files that hold them."""

from alloc.vehicle.degeneracy import RANK_TOLERANCE
from alloc.vehicle.model import LARGEST, Vehicle

__all__ = ["LARGEST", "RANK_TOLERANCE", "Vehicle"]
