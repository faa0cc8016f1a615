"""``thrustbench check``: a vehicle file checked (``check``), the ``remarks`` on it, and the ``report``."""
