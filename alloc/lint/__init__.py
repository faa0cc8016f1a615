"""``thrustbench check``: a vehicle file checked, the remarks on it by what they are about, and the report."""
