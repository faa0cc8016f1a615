"""A vehicle: its numbers (``model``), their ``geometry``, and the files that hold them."""

from alloc.vehicle.checks import LARGEST
from alloc.vehicle.degeneracy import RANK_TOLERANCE
from alloc.vehicle.model import Vehicle

__all__ = ["LARGEST", "RANK_TOLERANCE", "Vehicle"]
