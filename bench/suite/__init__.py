"""The pytest-benchmark modules: ``pytest bench/suite --benchmark-only``."""

import os

# One BLAS thread; read once, when numpy is first imported, so this stands before every import of it.
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")
