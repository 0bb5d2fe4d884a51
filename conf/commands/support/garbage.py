"""Keep the garbage collector from stopping a call."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def frozen_memory() -> Iterator[None]:
    """Leave what exists now out of all collections meanwhile.

    A full collection visits every module, function and network of the program, 0.1 s or more on a slow machine, with
    Python's lock held: the loudspeaker runs out of sound. What a call itself allocates is little.
    """
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
