"""Keep the memory of freed images for the next ones.

The C library of Linux (glibc) gives large blocks back to the system as soon as they are freed. Each image of a clip
then gets fresh pages, which the kernel must clear: as long as decoding and conversion take at 640x480.
"""

import ctypes
from functools import cache

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of mallopt(3)
KEPT_BYTES = 64 << 20  # free memory that is not given back: some images of 4096x2160
LARGEST_BLOCK = 32 << 20  # from the heap rather than from the system; the largest value that glibc takes


@cache
def keep_freed_memory() -> bool:
    """Tell the C library not to give freed images back, once for the process. Returns whether it could be told."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, TypeError, AttributeError):  # another C library, or Windows
        return False
    return bool(mallopt(_TRIM_THRESHOLD, KEPT_BYTES) and mallopt(_MMAP_THRESHOLD, LARGEST_BLOCK))
