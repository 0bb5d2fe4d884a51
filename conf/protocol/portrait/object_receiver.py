"""Receive objects: chunks in any order in, whole objects and acknowledgements out."""

from collections import OrderedDict
from dataclasses import dataclass, field

from conf.errors import ProtocolError
from conf.protocol.portrait.chunks import MAX_COMPLETE, MAX_PARTIAL, Ack, chunk_count, decode_chunk, encode_ack

PHOTO = 0  # the first byte of an object that is a photo
ACK_INTERVAL_S = 0.5
MAX_REMEMBERED = 256  # numbers of complete objects, whose late chunks are ignored


@dataclass
class _Partial:
    """The chunks of an object that have arrived. size : of a chunk, bytes"""

    size: int
    object_size: int
    chunks: dict[int, bytes] = field(default_factory=dict)

    @property
    def is_photo(self) -> bool:
        """Whether the object is known to be a photo."""
        return self.chunks.get(0, b"")[:1] == bytes((PHOTO,))

    @property
    def percent(self) -> int:
        """How much has arrived."""
        return 100 * len(self.chunks) // chunk_count(self.object_size, self.size)


class ObjectReceiver:
    """Receive the objects of one sender.

    rejected : chunks that were malformed or contradicted earlier ones
    """

    def __init__(self, receiver_id: int = 0) -> None:
        """receiver_id : 16 bits by which the sender recognises this receiver"""
        self.rejected = 0
        self._has_photo = False
        self._receiver_id = receiver_id & 0xFFFF
        self._partial: OrderedDict[int, _Partial] = OrderedDict()  # by object number
        self._complete: OrderedDict[int, None] = OrderedDict()
        self._unacknowledged: OrderedDict[int, None] = OrderedDict()  # complete, but the sender may not know it
        self._ack_pending = False
        self._gap_at_end = False  # the last chunk of an object has arrived, and not all before it
        self._acknowledged_at = float("-inf")

    @property
    def photo_percent(self) -> int | None:
        """How much has arrived of the newest photo, None if no photo has been announced."""
        arriving = [partial.percent for partial in self._partial.values() if partial.is_photo]
        return arriving[-1] if arriving else 100 if self._has_photo else None

    def receive_chunk(self, data: bytes) -> bytes | None:
        """Accept a chunk's body; return the object that it completes. Counts bad chunks in `rejected`, never raises."""
        try:
            chunk = decode_chunk(data)
            self._ack_pending = True
            number = chunk.object_number
            if number in self._complete:
                self._unacknowledged[number] = None
                return None
            partial = self._partial.setdefault(number, _Partial(chunk.size, chunk.object_size))
            if (partial.size, partial.object_size) != (chunk.size, chunk.object_size):
                raise ProtocolError("a chunk that contradicts those before it")
        except ProtocolError:
            self.rejected += 1
            return None
        partial.chunks[chunk.index] = chunk.data
        self._partial.move_to_end(number)
        if len(self._partial) > MAX_PARTIAL:
            self._partial.popitem(last=False)
        count = chunk_count(chunk.object_size, chunk.size)
        if len(partial.chunks) < count:
            self._gap_at_end = self._gap_at_end or chunk.index == count - 1
            return None
        del self._partial[number]
        self._has_photo |= partial.is_photo
        self._complete[number] = self._unacknowledged[number] = None
        if len(self._complete) > MAX_REMEMBERED:
            self._complete.popitem(last=False)
        return b"".join(partial.chunks[index] for index in range(count))

    def next_ack(self, now: float) -> bytes | None:
        """Return the body of an acknowledgement when one is due."""
        is_urgent = bool(self._unacknowledged) or self._gap_at_end
        if not self._ack_pending or (now - self._acknowledged_at < ACK_INTERVAL_S and not is_urgent):
            return None
        complete = tuple(self._unacknowledged)[:MAX_COMPLETE]
        for number in complete:
            del self._unacknowledged[number]
        self._ack_pending, self._gap_at_end = bool(self._unacknowledged), False
        self._acknowledged_at = now
        partial = tuple((number, frozenset(partial.chunks)) for number, partial in self._partial.items())
        return encode_ack(Ack(self._receiver_id, complete, partial))
