"""Closed forms f = G tau: ways to G, the allocator (``linear``), and rules that cut or scale its thrusts."""
