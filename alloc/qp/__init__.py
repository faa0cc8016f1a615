"""The quadratic program (``problem``), and how far an answer to it is from optimal (``certificate``)."""

from alloc.qp.problem import QP, Posed, pose_hard, pose_soft

__all__ = ["QP", "Posed", "pose_hard", "pose_soft"]
