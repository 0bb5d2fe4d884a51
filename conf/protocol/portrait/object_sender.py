"""The sending half: objects in slots, cut into pieces, sent within a budget and again until they are answered for."""

from dataclasses import dataclass, field

from conf.protocol.portrait.chunks import (
    CHUNK_SIZE_UNIT,
    MAX_OBJECT,
    MAX_PIECES,
    PIECE_HEADER,
    Chunk,
    decode_answer,
    encode_piece,
    piece_count,
)
from conf.protocol.portrait.queue_delay import QueueDelayModel
from conf.protocol.rate_limit import TokenBucket

PIECE_BYTES = 76  # alone, with headers and seal, it takes a link of 16 kbit/s no longer than a frame's time
RETRY_S = 0.8  # without an answer: answers come twice a second
REORDERED_S = 0.15  # a piece that is missing while one sent so much later has arrived is lost
# A call should not begin without a face: its first pieces, a draft and a photograph, may fill the link up to a multiple
# of the usual budget, motion counted, and what is not heard of is sent again soon: there is nothing better to carry.
START_BYTES = 9_000  # of pieces: a still face sends them alone, and their headers must not use it up
STARTUP_RATE_FACTOR = 3.9  # 15.6 kbit/s: a link of 16 keeps up with it
START_RETRY_S = 0.35
BURST_CHUNKS = 3  # of a budget after a rest, as far as motion does not wait for them
SLOWEST_LINK = 1950.0  # bytes a second: what a call with a picture is meant for, a little less than 16 kbit/s
MAX_ADDED_DELAY_S = 1 / 15  # on such a link: a frame's time
NUMBERS = 1 << 16


@dataclass
class _Outgoing:
    """An object on its way."""

    number: int
    data: bytes
    priority: int
    size: int
    sent: dict[int, float] = field(default_factory=dict)  # piece -> when last
    arrived: set[int] = field(default_factory=set)

    @property
    def count(self) -> int:
        return piece_count(len(self.data), self.size)

    def due(self, now: float, retry: float) -> int | None:
        """Return the first piece that was never sent, else the first that was not heard of for too long."""
        missing = [i for i in range(self.count) if i not in self.arrived]
        fresh = next((i for i in missing if i not in self.sent), None)
        return fresh if fresh is not None else next((i for i in missing if now - self.sent[i] >= retry), None)

    def on_ack(self, indices: frozenset[int]) -> None:
        """Take note of the pieces that have arrived, and of those that were overtaken: they count as never sent."""
        self.arrived |= {i for i in indices if i < self.count}
        newest = max((self.sent.get(i, float("-inf")) for i in self.arrived), default=float("-inf"))
        self.sent = {i: at for i, at in self.sent.items() if i in self.arrived or at > newest - REORDERED_S}

    def piece(self, index: int) -> Chunk:
        start = index * self.size
        return Chunk(self.number, self.size, index, len(self.data), self.data[start : start + self.size])


class ObjectSender:
    """Sends objects; `next_piece` is asked as often as there is room on the link."""

    def __init__(self, *, kbps: float = 4.0, piece_bytes: int = PIECE_BYTES) -> None:
        """Make an empty outbox.

        kbps : what the pieces may cost, headers included, in the long run; at the start START_FACTOR times that,
            less what `charge` tells of the motion
        Raises ValueError if piece_bytes is no multiple of 4 that cuts the largest object into at most 255 pieces.
        """
        sound = piece_bytes % CHUNK_SIZE_UNIT == 0 and 0 < piece_bytes // CHUNK_SIZE_UNIT < 256
        if not sound or piece_count(MAX_OBJECT, piece_bytes) > MAX_PIECES:
            raise ValueError(f"piece_bytes must be a multiple of {CHUNK_SIZE_UNIT} from 52 to 1020, got {piece_bytes}")
        self.kbps = kbps
        self.retry = RETRY_S  # seconds; at least a round trip and the time between two answers
        self.bytes_sent = 0
        self._start_bytes = START_BYTES  # what is left of them
        self._piece_bytes = piece_bytes
        start_rate = STARTUP_RATE_FACTOR * kbps * 125
        at_once = BURST_CHUNKS * piece_bytes
        self._bucket = TokenBucket(kbps * 125, at_once)
        self._link = TokenBucket(start_rate, at_once)  # motion counted
        self._hindrance = QueueDelayModel(max(start_rate, SLOWEST_LINK))
        self._outgoing: dict[int, _Outgoing] = {}  # by slot
        self._delivered: dict[int, _Outgoing] = {}  # by slot: kept for a receiver that begins anew
        self._next_number = 0
        self._token: int | None = None

    def send_object(self, slot: int, data: bytes, *, priority: int) -> None:
        """Send an object in place of what its slot held.

        slot : any number; urgency : the lowest is sent first
        Raises ValueError if the object is empty or larger than MAX_OBJECT.
        """
        if not 0 < len(data) <= MAX_OBJECT:
            raise ValueError(f"data must be 1 to {MAX_OBJECT} bytes, got {len(data)}")
        self._delivered.pop(slot, None)
        self._outgoing[slot] = _Outgoing(self._next_number, data, priority, self._piece_bytes)
        self._next_number = (self._next_number + 1) % NUMBERS

    def cancel(self, slot: int) -> None:
        """Stop sending what is in a slot, if anything is."""
        self._outgoing.pop(slot, None)
        self._delivered.pop(slot, None)

    def delivered(self, slot: int) -> bool:
        """Whether the receiver is known to have what the slot holds."""
        return slot in self._delivered

    @property
    def in_startup(self) -> bool:
        """Whether the first pieces are still on their way."""
        return self._start_bytes > 0

    @property
    def waiting_bytes(self) -> int:
        """Return how much has not been answered for."""
        return sum(len(o.data) - len(o.arrived) * o.size for o in self._outgoing.values())

    def next_chunk(self, now: float, *, overhead: int = 0) -> bytes | None:
        """Return the body of the next piece if one is due and the budget allows it.

        overhead : bytes that the datagram costs beside the body, if it is sent for this piece alone
        """
        retry = min(self.retry, START_RETRY_S) if self.in_startup else self.retry
        for outgoing in sorted(self._outgoing.values(), key=lambda o: (o.priority, o.number)):
            index = outgoing.due(now, retry)
            if index is None:
                continue
            body = encode_piece(outgoing.piece(index))
            if not self._affords(len(body) + overhead, now):
                return None
            outgoing.sent[index] = now
            self.bytes_sent += len(body) + overhead
            self._start_bytes -= len(body)
            return body
        return None

    def account_motion(self, size: int, now: float) -> None:
        """Note what else was sent, bytes with headers: at the start the pieces have what it leaves."""
        self._link.force_take(size, now)
        self._hindrance.add_motion(size, now)

    def _affords(self, size: int, now: float) -> bool:
        if self._hindrance.added_delay(size, now) > MAX_ADDED_DELAY_S:
            return False
        if self._bucket.take(size, now):
            self._link.force_take(size, now)
        elif not self.in_startup or not self._link.take(size, now):
            return False
        self._hindrance.add(size, now)
        return True

    def receive_answer(self, data: bytes) -> None:
        """Take note of what the receiver has. Raises ProtocolError if the bytes are no answer."""
        answer = decode_answer(data)
        if self._token is not None and answer.token != self._token:
            self.restart()
        self._token = answer.token
        finished = set(answer.complete)
        for slot, outgoing in list(self._outgoing.items()):
            if outgoing.number in finished:
                self._delivered[slot] = self._outgoing.pop(slot)
        partly = dict(answer.partial)
        for outgoing in self._outgoing.values():
            outgoing.on_ack(partly.get(outgoing.number, frozenset()))

    def restart(self) -> None:
        """Send everything again: the receiver has begun anew."""
        self._start_bytes = START_BYTES
        again = self._delivered | self._outgoing
        self._outgoing, self._delivered = {}, {}
        for slot, outgoing in sorted(again.items(), key=lambda item: item[1].number):
            self.send_object(slot, outgoing.data, priority=outgoing.priority)


WIRE_PIECE_BYTES = PIECE_HEADER + PIECE_BYTES
