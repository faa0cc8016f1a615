"""A project in C that measures methods on a board, and what its log says.

``project`` plans what is asked and writes the C: the driver and the ports of ``bench.chips``, kernels, and
demands as tables. ``log`` reads what a board printed, ``record`` makes a record of it. See docs/embedded.md
and docs/board-logs.md.
"""
