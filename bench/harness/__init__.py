"""The harness proper: plans, starts workers, times their calls, and keeps what they say."""
