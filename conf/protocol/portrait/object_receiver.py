"""The receiving half: pieces in any order, objects out, answers back. What does not fit is refused and counted."""

from collections import OrderedDict

from conf.errors import ProtocolError
from conf.protocol.portrait.chunks import (
    MAX_FINISHED,
    MAX_UNFINISHED,
    Ack,
    decode_piece,
    encode_answer,
    piece_count,
)

ANSWER_EVERY_S = 0.5
REMEMBERED = 256  # numbers of finished objects: their pieces that come late change nothing


class ObjectReceiver:
    """Collects the objects of one sender."""

    def __init__(self, token: int = 0) -> None:
        """Make an empty inbox; `token`, 16 bits, tells the sender that this is not the inbox before it."""
        self.rejected = 0
        self._token = token & 0xFFFF
        # By number: size of a piece, size of the object, the pieces.
        self._parts: OrderedDict[int, tuple[int, int, dict[int, bytes]]] = OrderedDict()
        self._finished: OrderedDict[int, None] = OrderedDict()
        self._to_answer: OrderedDict[int, None] = OrderedDict()  # numbers the sender may not know to be whole
        self._ack_pending = False
        self._gap_at_end = False  # the end of an object has come, and not all before it
        self._answered_at = float("-inf")

    def receive_chunk(self, data: bytes) -> bytes | None:
        """Take a piece's body; return the object that it completes. Counts what it refuses, never raises."""
        try:
            piece = decode_piece(data)
            self._ack_pending = True
            if piece.number in self._finished:
                self._to_answer[piece.number] = None
                return None
            size, total, pieces = self._parts.setdefault(piece.number, (piece.size, piece.object_size, {}))
            if (size, total) != (piece.size, piece.object_size):
                raise ProtocolError("a piece that contradicts those before it")
        except ProtocolError:
            self.rejected += 1
            return None
        pieces[piece.index] = piece.data
        self._parts.move_to_end(piece.number)
        if len(self._parts) > MAX_UNFINISHED:
            self._parts.popitem(last=False)
        if len(pieces) < piece_count(total, size):
            self._gap_at_end = self._gap_at_end or piece.index == piece_count(total, size) - 1
            return None
        del self._parts[piece.number]
        self._finish(piece.number)
        return b"".join(pieces[index] for index in range(len(pieces)))

    def next_ack(self, now: float) -> bytes | None:
        """Return the body of an answer when there is news and it is time."""
        urgent = bool(self._to_answer) or self._gap_at_end
        if not self._ack_pending or (now - self._answered_at < ANSWER_EVERY_S and not urgent):
            return None
        finished = tuple(self._to_answer)[:MAX_FINISHED]
        for number in finished:
            del self._to_answer[number]
        self._ack_pending, self._gap_at_end = bool(self._to_answer), False
        self._answered_at = now
        unfinished = tuple((number, frozenset(pieces)) for number, (_, _, pieces) in self._parts.items())
        return encode_answer(Ack(self._token, finished, unfinished))

    @property
    def held_bytes(self) -> int:
        """Return how much of unfinished objects is kept."""
        return sum(len(data) for _, _, pieces in self._parts.values() for data in pieces.values())

    def _finish(self, number: int) -> None:
        self._finished[number] = None
        self._to_answer[number] = None
        if len(self._finished) > REMEMBERED:
            self._finished.popitem(last=False)
