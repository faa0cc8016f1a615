"""Closed forms f = G tau without limits: ways to G, the allocator (``linear``), and rules for limits."""
