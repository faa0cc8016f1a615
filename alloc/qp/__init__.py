"""Quadratic program (``problem``) and how far an answer is from optimal (``certificate``).

``certify`` measures that for any QP, ``Stationarity`` for a soft one within a call.
"""

from alloc.qp.problem import QP, Posed, pose_hard, pose_soft

__all__ = ["QP", "Posed", "pose_hard", "pose_soft"]
