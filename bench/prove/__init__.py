"""What can be known of generated C for every input: a certificate with each file.

``harness`` makes the call that is analysed, ``eva`` has Frama-C read it, ``symbolic`` reads the C itself
into a list of operations, ``limits`` follows limits through it, ``certificate`` says what proof.json holds.
See docs/proof.md.
"""

from bench.prove.certificate import Certificate
from bench.prove.harness import Subject, subject
from bench.prove.page import summary
from bench.prove.prove import prove
from bench.prove.write import write

__all__ = ["Certificate", "Subject", "prove", "subject", "summary", "write"]
