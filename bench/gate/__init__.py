"""The regression gate: two trees of this project, measured side by side, and a verdict.

``run`` goes through it in order: ``trees`` prepares, ``answers`` judges, ``instructions`` counts,
``pairs`` times; all of it lands in a ``record``, and ``verdict`` is a function of that alone.
"""
