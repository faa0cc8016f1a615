"""The pytest-benchmark modules: ``pytest bench/suite --benchmark-only``."""

import os

from bench.harness.child import ONE_THREAD

# Before anything here imports numpy. What a user has set stands.
for _name, _threads in ONE_THREAD.items():
    os.environ.setdefault(_name, _threads)
