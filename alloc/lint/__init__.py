"""``thrustbench check``: what a vehicle file says about its vehicle (``check``), and that as text."""
