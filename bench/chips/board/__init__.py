"""A project in C that measures methods on a board, and what its log says.

``project`` writes the C: the driver and the ports of ``bench.chips``, its kernels, and demands as tables.
``measured`` makes a record of a log. See docs/embedded.md and docs/board-logs.md.
"""
