"""Instructions, flash and memory of generated C on processors that are not on the desk.

``toolchain`` says what runs where, ``kernel`` what C there is to run, ``image`` links it with a driver for
one processor, ``count`` runs that under QEMU and counts, ``search`` looks for the demand that costs
most, ``study`` puts rows into a record, and ``table`` turns rows into text. See docs/embedded.md.
"""
