"""The outgoing motion stream: frames in, message bodies out. No I/O, no clock.

Strategy. A frame is encoded when its datagram is about to be sent, predicted from the newest frame known to have
arrived. A face that has not moved visibly is not sent: a keep-alive each second confirms it, and its last frame is sent
again if a report shows that it was lost, or none shows that it has arrived. The stream parameters are repeated until
the receiver has acknowledged them, and sent again only when they change.
"""

from collections import OrderedDict
from collections.abc import Iterable, Sequence
from dataclasses import replace

from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.payload_header import MAX_FRAMES, MAX_STRIDE
from conf.protocol.codec.profiles import LIVE, Profile
from conf.protocol.messages import KeepAlive, MotionFrame, MotionPayload, Presence, StreamParameters
from conf.protocol.motion.furrow_announcer import FURROW_BYTES, FurrowAnnouncer
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.stream_clocks import StreamClock
from conf.protocol.wire import encode_body

REPEAT_S = 1.0  # interval of keep-alives and of parameters that are not acknowledged
UNCONFIRMED_S = 0.5  # after which the last frame before a face holds still is repeated unless it has arrived
FAPU_TOLERANCE = 0.02  # relative change of a FAPU distance that is not worth new parameters
TYPICAL_FRAME_BYTES = 5.0
SQUEEZE = 0.8  # of the mean size of a frame is enough, at a loss of precision
SMOOTHING = 8  # payloads: time constant of the mean size of a frame
MAX_IN_FLIGHT = 256  # datagrams remembered until they are acknowledged


class OutboundMotion:
    """Turn the motion of one sender into message bodies."""

    def __init__(
        self, parameters: StreamParameters, *, profile: Profile = LIVE, clock: StreamClock | None = None
    ) -> None:
        """clock : shared with the voice of the same sender"""
        self.parameters = parameters
        self.frames_sent = 0
        self._clock = clock or StreamClock()
        self._frames_per_datagram = profile.frames_per_datagram
        self._waits = False
        self._frame_bytes = TYPICAL_FRAME_BYTES
        self._begin_stream(profile)

    def _begin_stream(self, profile: Profile) -> None:
        self._encoder = Encoder(profile)
        self._pending: list[tuple[int, MotionFrame]] = []  # frames of the next datagram, with their numbers
        self._queue: list[OutgoingBody] = []
        self._in_flight: OrderedDict[int, OutgoingBody] = OrderedDict()  # by datagram counter
        self._clock.restart()
        self._newest = -1
        self._newest_counter = float("inf")  # of the datagram with the newest frame
        self._newest_arrived = False
        self._furrows = FurrowAnnouncer()
        self._acknowledged_parameters: StreamParameters | None = None
        self._parameters_due = self._keep_alive_due = self._repeat_due = float("-inf")

    @property
    def profile(self) -> Profile:
        """The profile that frames are encoded for."""
        return self._encoder.profile

    @property
    def datagram_interval_s(self) -> float:
        """Seconds from one datagram to the next while the face moves."""
        return self._frames_per_datagram / self.profile.fps

    @property
    def waiting(self) -> Sequence[OutgoingBody]:
        """The bodies that `drain` would return."""
        return self._queue

    def set_profile(self, profile: Profile, *, bundling: int = 1) -> None:
        """Change the profile. bundling : how many times its usual number of frames share a datagram"""
        if profile != self._encoder.profile:
            self._flush()
            self._newest = self._frame_number(self._newest / self._encoder.profile.fps, profile)
            self._encoder.profile = profile
        self._frames_per_datagram = min(profile.frames_per_datagram * bundling, MAX_FRAMES)

    def wait_for_flush(self, waits: bool) -> None:
        """Choose whether frames wait for `flush`, however few or many a datagram usually has."""
        self._waits = waits
        if not waits and len(self._pending) >= self._frames_per_datagram:
            self._flush()

    def flush(self, max_bytes: float = float("inf")) -> None:
        """Queue the frames that wait: all, or every second or fourth if they are likely to exceed `max_bytes`.

        The newest is always among them. If even these exceed it, none is queued.
        """
        stride = self._pending[1][0] - self._pending[0][0] if len(self._pending) > 1 else 1
        for step in (1, 2, MAX_STRIDE):
            kept = self._pending[::-step][::-1] if stride * step <= MAX_STRIDE else self._pending[-1:]
            if 1 + SQUEEZE * len(kept) * self._frame_bytes <= max_bytes:
                self._pending = kept
                self._flush(max_bytes)
                return
        self._pending.clear()

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Send one frame."""
        stream_time = self._clock.stream_time(frame.timestamp)
        number = self._frame_number(stream_time, self.profile)
        if number <= self._newest:
            return
        self._queue_parameters(stream_time, now)
        differs = bool(self._pending) or self._differs_visibly(frame)
        if not differs:
            if self._newest_arrived and now >= self._keep_alive_due:
                self._queue_keep_alive(stream_time, Presence.FACE, now)
            if self._newest_arrived or now < self._repeat_due:
                return
        if self._pending and not self._fits_pending(number):
            self._flush()
        self._pending.append((number, frame))
        self._newest, self._newest_arrived, self._newest_counter = number, False, float("inf")
        self._keep_alive_due = now + REPEAT_S
        self._repeat_due = now + (UNCONFIRMED_S if differs else REPEAT_S)
        if len(self._pending) >= (MAX_FRAMES if self._waits else self._frames_per_datagram):
            self._flush()

    def send_no_face(self, timestamp: float, now: float) -> None:
        """Report that there is no face at `timestamp`."""
        self._flush()
        stream_time = self._clock.stream_time(timestamp)
        self._queue_parameters(stream_time, now)
        if now >= self._keep_alive_due:
            self._queue_keep_alive(stream_time, Presence.NO_FACE, now)

    def discard(self) -> None:
        """Remove all that waits to be sent."""
        self._pending.clear()
        self._queue.clear()

    def probe(self, timestamp: float) -> OutgoingBody:
        """Return a keep-alive to which a receiver would report."""
        return OutgoingBody(encode_body(KeepAlive(self._clock.stream_time(timestamp), Presence.FACE)))

    def drain(self) -> list[OutgoingBody]:
        """Return the bodies to send and empty the queue."""
        queue, self._queue = self._queue, []
        return queue

    def on_sent(self, counter: int, outgoing: OutgoingBody) -> None:
        """Record the counter of the datagram in which a body was sent."""
        if self._newest in outgoing.frame_numbers:
            self._newest_counter = counter
        self._furrows.on_sent(counter, outgoing)
        self._in_flight[counter] = outgoing
        if len(self._in_flight) > MAX_IN_FLIGHT:
            self._in_flight.popitem(last=False)

    def on_acknowledged(self, counters: Iterable[int]) -> None:
        """Apply the counters that the receiver has decoded: frames may be predicted from theirs."""
        decoded = list(counters)
        self._furrows.on_acknowledged(decoded)
        for counter in decoded:
            outgoing = self._in_flight.pop(counter, None)
            if outgoing is None:
                continue
            self._encoder.acknowledge(outgoing.frame_numbers)
            self._newest_arrived |= self._newest in outgoing.frame_numbers
            self._acknowledged_parameters = outgoing.parameters or self._acknowledged_parameters
        if not self._newest_arrived and max(decoded, default=-1) > self._newest_counter:
            self._repeat_due = float("-inf")  # it was lost: even if the face holds still, do not wait

    def drop_references(self) -> None:
        """Predict from nothing: the receiver misses a reference frame."""
        self._encoder.drop_references()
        self._in_flight.clear()

    def restart(self) -> None:
        """Begin a new session, whose receiver knows nothing: the stream's clock and frame numbers start again."""
        self._begin_stream(self.profile)

    @staticmethod
    def _frame_number(stream_time: float, profile: Profile) -> int:
        return round(stream_time * profile.fps)

    def _differs_visibly(self, frame: MotionFrame) -> bool:
        return self._encoder.differs_visibly(frame) or self._furrows.is_due(frame.furrow, frame.timestamp)

    def _fits_pending(self, number: int) -> bool:
        """Return whether a frame continues the pending ones: the steps in a datagram are equal and short."""
        step = number - self._pending[-1][0]
        first_step = self._pending[1][0] - self._pending[0][0] if len(self._pending) > 1 else step
        return step == first_step and step <= MAX_STRIDE

    def _flush(self, max_bytes: float = float("inf")) -> None:
        if not self._pending:
            return
        numbers = tuple(number for number, _ in self._pending)
        stride = numbers[1] - numbers[0] if len(numbers) > 1 else 1
        frames = [frame for _, frame in self._pending]
        payload = self._encoder.encode(frames, numbers[0], stride=stride, max_bytes=max_bytes - 1)
        self._pending.clear()
        self._frame_bytes += (len(payload) / len(numbers) - self._frame_bytes) / SMOOTHING
        room = max_bytes - 1 - len(payload)
        if room >= 0:
            furrow, timestamp = frames[-1].furrow, frames[-1].timestamp
            if room >= FURROW_BYTES and self._furrows.is_due(furrow, timestamp):
                self._queue.append(self._furrows.body(furrow, timestamp))
            self._queue.append(OutgoingBody(encode_body(MotionPayload(numbers[0], payload)), numbers))
            self.frames_sent += len(numbers)

    def _queue_parameters(self, stream_time: float, now: float) -> None:
        acknowledged = self._acknowledged_parameters
        if now < self._parameters_due or (acknowledged and _are_close(acknowledged, self.parameters)):
            return
        self._parameters_due = now + REPEAT_S
        parameters = replace(self.parameters, fps=float(self.profile.fps), clock=stream_time)
        self._queue.append(OutgoingBody(encode_body(parameters), parameters=self.parameters))

    def _queue_keep_alive(self, stream_time: float, presence: Presence, now: float) -> None:
        self._keep_alive_due = now + REPEAT_S
        self._queue.append(OutgoingBody(encode_body(KeepAlive(stream_time, presence))))


def _are_close(a: StreamParameters, b: StreamParameters) -> bool:
    has_close_fapu = all(abs(x - y) <= FAPU_TOLERANCE * x for x, y in zip(a.fapu, b.fapu, strict=True))
    return has_close_fapu and replace(a, fapu=b.fapu) == b
