"""Closed forms f = G tau: ways to G, the allocator without limits (``linear``), and rules that cut or scale it."""
