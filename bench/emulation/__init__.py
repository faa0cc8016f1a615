"""Instructions, flash and memory of generated C on processors that are not on the desk.

``toolchain`` says what runs where, ``kernel`` what C there is to run, ``image`` links it with a driver for
one processor, ``count`` runs that under QEMU and counts, ``search`` looks for the demand that costs
most, ``study`` makes the rows that ``record`` keeps; ``rows`` reads them again, and ``bands`` and
``bench.report.emulation`` say what they mean. See docs/embedded.md.
"""
