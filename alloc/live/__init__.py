"""An allocator around a QP solver: prepared once (``allocator``), or nothing prepared (``one_shot``)."""
