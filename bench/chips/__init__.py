"""Instructions, flash and memory of generated C on processors that are not on the desk.

``toolchain`` names a compiler and an emulator for each processor, ``kernels`` makes the C of each method,
``image`` links it with a driver for one processor, ``count`` runs the image under QEMU and counts,
``agreement`` compares its answers with Python's, ``search`` looks for the call that costs most, and ``study``
writes the rows of a record. ``bench.results.emulated`` reads them again. See docs/counting.md.
"""
