"""The quadratic program (``problem``), its right-hand sides (``sides``), how far an answer is from optimal.

``certificate`` measures that for any QP, ``stationarity`` for a soft one within a call.
"""

from alloc.qp.problem import QP, Posed, pose_hard, pose_soft

__all__ = ["QP", "Posed", "pose_hard", "pose_soft"]
