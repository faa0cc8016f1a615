"""Keeps freed memory in the process, since the system clears each page that it gives again."""

import ctypes
from functools import lru_cache

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
LARGEST_MMAP_THRESHOLD = 32 << 20
"""glibc's bound; larger arrays than this are still given back at once."""


@lru_cache(maxsize=1)
def keep_freed_memory() -> bool:
    """Whether glibc was told to give memory back above 32 MB only; nothing changes elsewhere.

    Dask starts its workers with a threshold of 64 kB, which costs half of a shard's time.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):  # another C library
        return False
    set_both = [mallopt(key, LARGEST_MMAP_THRESHOLD) for key in (M_TRIM_THRESHOLD, M_MMAP_THRESHOLD)]
    return all(set_both)
