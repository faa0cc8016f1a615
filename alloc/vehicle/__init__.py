"""A vehicle: its numbers (``model``), their ``geometry``, and the files that hold them."""

from alloc.vehicle.model import LARGEST, RANK_TOLERANCE, Vehicle

__all__ = ["LARGEST", "RANK_TOLERANCE", "Vehicle"]
