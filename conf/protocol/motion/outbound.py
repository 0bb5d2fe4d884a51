"""The sending half of the motion: frames in, bodies to seal out. No I/O, no clock.

Strategy. A frame is encoded when its datagram is about to leave, predicted from the newest frame that is known to have
arrived. A face that has not moved visibly is not sent: a keep-alive each second says that it is still there. The
stream's parameters are sent again and again until the receiver has them, and then only when they change.
"""

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, replace

from conf.protocol.codec import LIVE, Encoder, Profile
from conf.protocol.codec.payload_header import MAX_FRAMES, MAX_STRIDE
from conf.protocol.messages import KeepAlive, MotionFrame, MotionPayload, Presence, StreamParameters
from conf.protocol.wire import encode_body

REPEAT_S = 1.0  # parameters that are not acknowledged, and keep-alives
FAPU_TOLERANCE = 0.02  # a neutral face that settles by less than this is not told again
MAX_IN_FLIGHT = 256  # datagrams on their way


@dataclass(frozen=True)
class OutgoingBody:
    """A body to seal and send, and what its arrival would mean.

    numbers : of the frames it carries; motion : the same as the codec wrote them
    parameters : the stream parameters it carries, if any
    """

    body: bytes
    numbers: tuple[int, ...] = ()
    motion: MotionPayload | None = None
    parameters: StreamParameters | None = None


class OutboundMotion:
    """Turn the motion of one sender into bodies."""

    def __init__(self, parameters: StreamParameters, *, profile: Profile = LIVE) -> None:
        self.parameters = parameters
        self.frames_sent = 0
        self._encoder = Encoder(profile)
        self._bundle = profile.frames_per_datagram
        self._pending: list[tuple[int, MotionFrame]] = []
        self._queue: list[OutgoingBody] = []
        self._in_flight: OrderedDict[int, OutgoingBody] = OrderedDict()
        self._origin: float | None = None  # the session's first timestamp: the stream's clock starts there
        self._newest = -1
        self._newest_arrived = False
        self._arrived: StreamParameters | None = None
        self._parameters_due = self._keep_alive_due = float("-inf")

    @property
    def profile(self) -> Profile:
        """The profile frames are coded for."""
        return self._encoder.profile

    def set_profile(self, profile: Profile, *, bundling: int = 1) -> None:
        """Go on with another profile; bundling : how many times its usual number of frames share a datagram."""
        if profile != self._encoder.profile:
            self._flush()
            self._newest = self._number(self._newest / self._encoder.profile.fps, profile)
            self._encoder.profile = profile
        self._bundle = min(profile.frames_per_datagram * bundling, MAX_FRAMES)

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Take one frame's motion."""
        stamp = self._stream_time(frame.timestamp)
        number = self._number(stamp, self.profile)
        if number <= self._newest:
            return
        self._queue_parameters(stamp, now)
        if not self._pending and not self._encoder.differs_visibly(frame):
            if now < self._keep_alive_due:
                return
            if self._newest_arrived:
                self._queue_keep_alive(stamp, Presence.FACE, now)
                return
        if self._pending and not self._continues(number):
            self._flush()
        self._pending.append((number, frame))
        self._newest, self._newest_arrived = number, False
        self._keep_alive_due = now + REPEAT_S
        if len(self._pending) >= self._bundle:
            self._flush()

    def send_absence(self, timestamp: float, now: float) -> None:
        """Note that there is no face at `timestamp`."""
        self._flush()
        stamp = self._stream_time(timestamp)
        self._queue_parameters(stamp, now)
        if now >= self._keep_alive_due:
            self._queue_keep_alive(stamp, Presence.NO_FACE, now)

    def probe(self, timestamp: float) -> OutgoingBody:
        """Return a keep-alive that asks whether anybody is there."""
        return OutgoingBody(encode_body(KeepAlive(self._stream_time(timestamp), Presence.FACE)))

    def drain(self) -> list[OutgoingBody]:
        """Take what is to be sent."""
        queue, self._queue = self._queue, []
        return queue

    def on_sent(self, counter: int, outgoing: OutgoingBody) -> None:
        """Note under which counter a body has left."""
        self._in_flight[counter] = outgoing
        if len(self._in_flight) > MAX_IN_FLIGHT:
            self._in_flight.popitem(last=False)

    def on_acknowledged(self, counters: Iterable[int]) -> None:
        """Note the counters that the receiver has and understood: frames may be predicted from theirs."""
        for counter in counters:
            outgoing = self._in_flight.pop(counter, None)
            if outgoing is None:
                continue
            self._encoder.acknowledge(outgoing.numbers)
            self._newest_arrived |= self._newest in outgoing.numbers
            self._arrived = outgoing.parameters or self._arrived

    def drop_references(self) -> None:
        """Predict from nothing: the receiver misses what it was thought to have."""
        self._encoder.drop_references()
        self._in_flight.clear()

    def restart(self) -> None:
        """Begin a new session with a receiver that knows nothing: the stream's clock and its numbers start again."""
        self._encoder = Encoder(self.profile)
        self._in_flight.clear()
        self._queue.clear()
        self._pending.clear()
        self._origin = None
        self._newest = -1
        self._arrived = None
        self._newest_arrived = False
        self._parameters_due = self._keep_alive_due = float("-inf")

    def _stream_time(self, timestamp: float) -> float:
        self._origin = timestamp if self._origin is None else self._origin
        return max(timestamp - self._origin, 0.0)

    @staticmethod
    def _number(stream_time: float, profile: Profile) -> int:
        return round(stream_time * profile.fps)

    def _continues(self, number: int) -> bool:
        """Say whether a frame fits into the pending bundle: the steps between its frames are equal and short."""
        step = number - self._pending[-1][0]
        first_step = self._pending[1][0] - self._pending[0][0] if len(self._pending) > 1 else step
        return step == first_step and step <= MAX_STRIDE

    def _flush(self) -> None:
        if not self._pending:
            return
        numbers = tuple(number for number, _ in self._pending)
        stride = numbers[1] - numbers[0] if len(numbers) > 1 else 1
        payload = self._encoder.encode([frame for _, frame in self._pending], numbers[0], stride=stride)
        motion = MotionPayload(numbers[0], payload)
        self._queue.append(OutgoingBody(encode_body(motion), numbers, motion))
        self.frames_sent += len(self._pending)
        self._pending.clear()

    def _queue_parameters(self, stamp: float, now: float) -> None:
        if now < self._parameters_due or (self._arrived and _alike(self._arrived, self.parameters)):
            return
        self._parameters_due = now + REPEAT_S
        told = replace(self.parameters, fps=float(self.profile.fps), clock=stamp)
        self._queue.append(OutgoingBody(encode_body(told), parameters=self.parameters))

    def _queue_keep_alive(self, stamp: float, presence: Presence, now: float) -> None:
        self._keep_alive_due = now + REPEAT_S
        self._queue.append(OutgoingBody(encode_body(KeepAlive(stamp, presence))))


def _alike(a: StreamParameters, b: StreamParameters) -> bool:
    near = all(abs(x - y) <= FAPU_TOLERANCE * x for x, y in zip(a.fapu, b.fapu, strict=True))
    return near and replace(a, fapu=b.fapu) == b
