"""Proofs about generated C for every input, one with each file.

``harness`` makes the call that is analysed, ``eva`` has Frama-C read it, ``symbolic`` reads the C itself
into a list of operations, ``limits`` follows limits through it, ``proof`` says what proof.json holds.
See docs/proof.md.
"""

from bench.proof.certify import THOROUGH, USUAL, prove
from bench.proof.library import prove_library
from bench.proof.page import summary
from bench.proof.proof import Proof
from bench.proof.subject import Subject, subject
from bench.proof.write import write

__all__ = ["THOROUGH", "USUAL", "Proof", "Subject", "prove", "prove_library", "subject", "summary", "write"]
