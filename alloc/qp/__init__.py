"""The quadratic program (``problem``), and what an answer to it is worth (``certificate``)."""

from alloc.qp.problem import QP, Posed, pose_hard, pose_soft

__all__ = ["QP", "Posed", "pose_hard", "pose_soft"]
