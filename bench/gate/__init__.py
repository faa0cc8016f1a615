"""The regression gate: two trees of this project, measured side by side, and a verdict.

``run`` calls the stages in order: ``trees`` prepares, ``answers`` judges, ``instructions`` counts, ``pairs``
times. Every stage writes into a ``record``, and ``verdict`` is a function of the record alone.
"""
