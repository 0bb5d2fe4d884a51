"""Send objects reliably: divided into chunks, each sent again until it is acknowledged."""

from dataclasses import dataclass, field

from conf.protocol.portrait.chunk_budget import CHUNK_BYTES, ChunkBudget
from conf.protocol.portrait.chunks import MAX_OBJECT_BYTES, Chunk, chunk_count, decode_ack, encode_chunk

RETRY_S = 0.8  # without an acknowledgement: they arrive twice a second
STARTUP_RETRY_S = 0.35  # during startup there is nothing better to send
REORDER_WINDOW_S = 0.15  # a missing chunk is lost if one sent so much later has arrived
OBJECT_NUMBERS = 1 << 16


@dataclass
class _Transfer:
    """An object that is being sent."""

    number: int
    data: bytes
    priority: int
    last_sent: dict[int, float] = field(default_factory=dict)  # by chunk index
    arrived: set[int] = field(default_factory=set)

    def next_due(self, now: float, retry_s: float) -> int | None:
        """Return the first chunk never sent, else the first unacknowledged for `retry_s`, else None."""
        missing = [i for i in range(chunk_count(len(self.data), CHUNK_BYTES)) if i not in self.arrived]
        fresh = next((i for i in missing if i not in self.last_sent), None)
        return fresh if fresh is not None else next((i for i in missing if now - self.last_sent[i] >= retry_s), None)

    def on_ack(self, indices: frozenset[int]) -> None:
        """Note the chunks that have arrived. Those overtaken by them are lost and count as never sent."""
        self.arrived |= {i for i in indices if i < chunk_count(len(self.data), CHUNK_BYTES)}
        newest = max((self.last_sent.get(i, float("-inf")) for i in self.arrived), default=float("-inf"))
        kept = {i: at for i, at in self.last_sent.items() if i in self.arrived or at > newest - REORDER_WINDOW_S}
        self.last_sent = kept

    def chunk(self, index: int) -> Chunk:
        start = index * CHUNK_BYTES
        return Chunk(self.number, CHUNK_BYTES, index, len(self.data), self.data[start : start + CHUNK_BYTES])


class ObjectSender:
    """Send the newest object of each slot."""

    def __init__(self) -> None:
        self._transfers: dict[int, _Transfer] = {}  # by slot
        self._delivered: dict[int, _Transfer] = {}  # by slot: kept for a receiver that starts again
        self._next_number = 0
        self._receiver_id: int | None = None

    def send_object(self, slot: int, data: bytes, *, priority: int) -> None:
        """Send an object, and stop sending the previous one of its slot.

        slot : any number; priority : the lowest is sent first
        Raises ValueError if the object is empty or larger than MAX_OBJECT_BYTES.
        """
        if not 0 < len(data) <= MAX_OBJECT_BYTES:
            raise ValueError(f"data must be 1 to {MAX_OBJECT_BYTES} bytes, got {len(data)}")
        self._delivered.pop(slot, None)
        self._transfers[slot] = _Transfer(self._next_number, data, priority)
        self._next_number = (self._next_number + 1) % OBJECT_NUMBERS

    def cancel(self, slot: int) -> None:
        """Stop sending the object of a slot, if it has one."""
        self._transfers.pop(slot, None)
        self._delivered.pop(slot, None)

    def delivered(self, slot: int) -> bool:
        """Return whether the receiver has acknowledged the whole object of the slot."""
        return slot in self._delivered

    @property
    def waiting_bytes(self) -> int:
        """Bytes not acknowledged yet."""
        return self.waiting_bytes_before(None)

    def waiting_bytes_before(self, priority: int | None) -> int:
        """Return the bytes not acknowledged yet of objects that are sent before those of a priority; None: of all."""
        waiting = [t for t in self._transfers.values() if priority is None or t.priority < priority]
        return sum(len(t.data) - len(t.arrived) * CHUNK_BYTES for t in waiting)

    def next_chunk(self, now: float, budget: ChunkBudget, *, overhead: int = 0) -> bytes | None:
        """Return the body of the next chunk if one is due and the budget allows it.

        overhead : bytes that the datagram costs beside the body
        """
        retry_s = STARTUP_RETRY_S if budget.in_startup else RETRY_S
        for transfer in sorted(self._transfers.values(), key=lambda t: (t.priority, t.number)):
            index = transfer.next_due(now, retry_s)
            if index is None:
                continue
            body = encode_chunk(transfer.chunk(index))
            if not budget.consume(len(body), now, overhead=overhead):
                return None
            transfer.last_sent[index] = now
            return body
        return None

    def receive_ack(self, data: bytes) -> bool:
        """Apply an acknowledgement. Raises ProtocolError if the bytes are none.

        Returns whether it is of a new receiver, to which everything is sent again.
        """
        ack = decode_ack(data)
        is_new = self._receiver_id is not None and ack.receiver_id != self._receiver_id
        if is_new:
            self.restart()
        self._receiver_id = ack.receiver_id
        for slot, transfer in list(self._transfers.items()):
            if transfer.number in ack.complete:
                self._delivered[slot] = self._transfers.pop(slot)
        partial = dict(ack.partial)
        for transfer in self._transfers.values():
            transfer.on_ack(partial.get(transfer.number, frozenset()))
        return is_new

    def restart(self) -> None:
        """Send everything again: the receiver has started again."""
        again = self._delivered | self._transfers
        self._transfers, self._delivered = {}, {}
        for slot, transfer in sorted(again.items(), key=lambda item: item[1].number):
            self.send_object(slot, transfer.data, priority=transfer.priority)
