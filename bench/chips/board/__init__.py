"""A project in C that measures methods on a board, and what its log says.

``project`` plans what is asked, ``files`` writes the C: the driver and the ports of ``bench.chips``, kernels,
and demands as tables. ``header`` and ``heard`` read a log, ``measured`` makes a record of it. See
docs/embedded.md and docs/board-logs.md.
"""
