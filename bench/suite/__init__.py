"""The pytest-benchmark modules: ``pytest bench/suite --benchmark-only``."""

import os

from bench.harness import ONE_THREAD

# The libraries under numpy read these once, so they are set before numpy is imported; a user's own stand.
for _name, _threads in ONE_THREAD.items():
    os.environ.setdefault(_name, _threads)
