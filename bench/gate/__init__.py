"""Regression gate: two trees of this project, measured side by side, and a verdict.

``run`` calls the stages in order: ``trees`` prepares, ``examine`` judges, then instructions are counted and
pairs timed. Every stage writes into a ``record``, and ``verdict`` is a function of the record alone. Each
``side`` is a process as the harness starts its workers; ``contract`` is asked at the gate and by tests.
"""
