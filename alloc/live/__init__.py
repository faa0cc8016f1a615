"""An allocator around a QP solver prepared once (``allocator``) or set up at each call (``one_shot``)."""
