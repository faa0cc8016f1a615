"""A rigid vehicle under a tracking controller: where time-correlated demands come from.

``body`` moves, ``autopilot`` demands, ``simulate`` lets the one act on the other through a
failure half way. The sets ``mission`` and ``mission-fault`` are its two halves.
"""
