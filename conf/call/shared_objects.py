"""The portrait's objects between the thread that captures and the loop that sends."""

import threading
from collections.abc import Callable

from conf.protocol.portrait.chunk_budget import ChunkBudget
from conf.protocol.portrait.object_sender import ObjectSender


class SharedObjectSender(ObjectSender):
    """An object sender for two threads: one fills it, the other sends. Each call holds a lock.

    is_allowed : whether images of the person may be sent now
    """

    def __init__(self, *, on_object: Callable[[bytes], None] = lambda data: None) -> None:
        """on_object : called with each object that is to be sent, by the thread that fills"""
        super().__init__()
        self.is_allowed = False
        self._on_object = on_object
        self._lock = threading.RLock()

    def send_object(self, slot: int, data: bytes, *, priority: int) -> None:
        """Send an object as ObjectSender does."""
        with self._lock:
            super().send_object(slot, data, priority=priority)
        self._on_object(data)

    def cancel(self, slot: int) -> None:
        """Stop sending the object of a slot, if it has one."""
        with self._lock:
            super().cancel(slot)

    def delivered(self, slot: int) -> bool:
        """Return whether the receiver has acknowledged the whole object of the slot."""
        with self._lock:
            return super().delivered(slot)

    @property
    def waiting_bytes(self) -> int:
        """Bytes not acknowledged yet."""
        with self._lock:
            return super().waiting_bytes

    def waiting_bytes_before(self, priority: int | None) -> int:
        """Return the bytes not acknowledged yet of objects that are sent before those of a priority; None: of all."""
        with self._lock:
            return super().waiting_bytes_before(priority)

    def next_chunk(self, now: float, budget: ChunkBudget, *, overhead: int = 0) -> bytes | None:
        """Return the body of the next chunk as ObjectSender does, None while no images may be sent."""
        with self._lock:
            return super().next_chunk(now, budget, overhead=overhead) if self.is_allowed else None

    def receive_ack(self, data: bytes) -> bool:
        """Apply an acknowledgement as ObjectSender does."""
        with self._lock:
            return super().receive_ack(data)

    def restart(self) -> None:
        """Send everything again."""
        with self._lock:
            super().restart()
