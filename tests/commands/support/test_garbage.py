"""What exists before a call is not visited by the garbage collector during it."""

import gc
import weakref

from conf.commands.support.garbage import frozen_memory


class Cycle:
    """Refers to itself, so that only the garbage collector frees it."""

    def __init__(self) -> None:
        self.itself = self


def test_what_exists_is_left_alone_until_the_end_and_what_is_new_is_collected() -> None:
    gc.collect()
    gc.disable()
    try:
        old = Cycle()
        old_alive = weakref.ref(old)
        with frozen_memory():
            new = Cycle()
            new_alive = weakref.ref(new)
            del old, new
            gc.collect()
            assert old_alive() is not None and new_alive() is None
        gc.collect()
        assert old_alive() is None
    finally:
        gc.enable()
