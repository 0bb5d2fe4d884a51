"""Threads that sound devices wait for run before others."""

import contextlib
import os
import sys
import threading

NICENESS = -11  # the same that sound servers ask for


def raise_thread_priority() -> None:
    """Let the calling thread run before others, if the system allows it: on Linux in real time, else sooner.

    For a thread that computes a little at a time and must not be late: an ordinary one waits up to 40 ms for a
    processor that others use. The main thread, which does all else, stays as it is. Elsewhere the library of sound
    devices does as much for its own threads.
    """
    if sys.platform != "linux" or threading.get_ident() == threading.main_thread().ident:
        return
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(1))
    except OSError:
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)
