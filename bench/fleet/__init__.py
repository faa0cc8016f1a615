"""Many machines that measure themselves: each Dask worker's host runs `thrustbench run`, records come back."""
