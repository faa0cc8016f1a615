"""f = G tau without limits, by several ways to G (``linear`` is the allocator), and the rules behind it."""
