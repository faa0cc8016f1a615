"""Proofs about generated C for every input, one with each file.

``safety.harness`` makes the call that is analysed, ``safety.eva`` has Frama-C read it, ``symbolic`` reads
the C itself into a list of operations, ``proof`` says what proof.json holds.
See docs/proof.md.
"""

from bench.proof.certify import THOROUGH, USUAL, prove
from bench.proof.library import prove_library
from bench.proof.page import summary, write
from bench.proof.proof import Proof
from bench.proof.source import Subject, subject

__all__ = ["THOROUGH", "USUAL", "Proof", "Subject", "prove", "prove_library", "subject", "summary", "write"]
