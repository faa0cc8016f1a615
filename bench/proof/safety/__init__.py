"""No run-time error, and thrusts inside the limits: what Frama-C shows, and a comparison of the C's own."""
