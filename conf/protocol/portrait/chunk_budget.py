"""The part of the link that portrait chunks may use."""

from conf.protocol.rate_control.rate_limit import TokenBucket

DEFAULT_KBPS = 4.0
CHUNK_BYTES = 76  # alone, with headers and seal, it occupies a link of 16 kbit/s no longer than a frame's time
# A call should not begin without a face. Its first chunks, a draft and a photo, may fill the link up to a multiple of
# the long-term budget, motion included: 15.6 kbit/s by default, which a link of 16 carries.
STARTUP_BYTES = 12_000  # of chunks; their headers do not count, as a still face sends each chunk alone
# From the first chunk, which a face gives about two seconds after the first frame: what has not been sent by then is no
# startup any more, so that the rates below hold from the tenth second of a call on.
STARTUP_S = 7.8
STARTUP_RATE_FACTOR = 3.9
# Then motion and chunks together have 7.02 kbit/s by default, with the burst at most 7.2 over any twenty seconds. What
# lively motion took beyond it is saved later. Where that debt exceeds some seconds of the joint rate, the motion has
# voice or a profile beside it that always needs more: then chunks have 1.1 kbit/s.
JOINT_RATE_FACTOR = 1.755
MIN_RATE_FACTOR = 0.275
JOINT_BURST_S = 0.4  # of the joint rate: what a still face leaves is used later
JOINT_DEBT_S = 3.0  # of the joint rate
NEAR_DEBT_S = 0.2  # from the greatest debt within which it counts as reached: motion fills it frame by frame
BURST_CHUNKS = 3  # token-bucket burst, in chunks
MIN_LINK_RATE = 1950.0  # bytes a second of the slowest link that a call with a portrait is meant for: 16 kbit/s
MAX_ADDED_DELAY_S = 1 / 15  # on such a link: a frame's time


class QueueDelayModel:
    """Model the queue of a link of `rate` bytes a second twice: with all traffic, and with the motion alone.

    The difference is what the other traffic adds, whatever the amount of motion.
    Source: Lindley 1952 (the wait in a queue from one arrival to the next).
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._all = self._motion = 0.0  # bytes in the queue
        self._updated_at: float | None = None

    def added_delay(self, size: int, now: float) -> float:
        """Return the seconds that motion sent now would wait for other traffic if `size` more bytes of it were sent."""
        self._drain(now)
        return (self._all - self._motion + size) / self._rate

    def add(self, size: int, now: float) -> None:
        """Count bytes sent that are not motion."""
        self._drain(now)
        self._all += size

    def add_motion(self, size: int, now: float) -> None:
        """Count bytes of motion sent."""
        self._drain(now)
        self._all += size
        self._motion += size

    def _drain(self, now: float) -> None:
        drained = 0.0 if self._updated_at is None else max(0.0, now - self._updated_at) * self._rate
        self._all, self._motion = max(0.0, self._all - drained), max(0.0, self._motion - drained)
        self._updated_at = now


class ChunkBudget:
    """Decide whether a chunk may be sent now.

    kbps : long-term rate of the chunks, headers included; with motion, JOINT_RATE_FACTOR times that, and during
        startup STARTUP_RATE_FACTOR times
    bytes_sent : bytes of the chunks so far, headers included
    """

    def __init__(self, kbps: float = DEFAULT_KBPS) -> None:
        rate, burst = kbps * 125, BURST_CHUNKS * CHUNK_BYTES
        joint = JOINT_RATE_FACTOR * rate
        self.bytes_sent = 0
        self._chunks = TokenBucket(rate, burst)
        self._link = TokenBucket(STARTUP_RATE_FACTOR * rate, burst)  # chunks and motion
        self._joint = TokenBucket(joint, JOINT_BURST_S * joint, max_debt=JOINT_DEBT_S * joint)  # the same
        self._max_debt = (JOINT_DEBT_S - NEAR_DEBT_S) * joint
        self._least = TokenBucket(MIN_RATE_FACTOR * rate, burst)
        self._queue = QueueDelayModel(max(STARTUP_RATE_FACTOR * rate, MIN_LINK_RATE))
        self._startup_left = STARTUP_BYTES
        self._startup_end: float | None = None  # seconds, known from the first chunk on

    @property
    def in_startup(self) -> bool:
        """Whether the first STARTUP_BYTES are still being sent, within STARTUP_S."""
        return self._startup_left > 0

    def restart(self) -> None:
        """Begin the startup again: a new receiver has nothing."""
        self._startup_left, self._startup_end = STARTUP_BYTES, None

    def consume(self, size: int, now: float, *, overhead: int = 0) -> bool:
        """Return whether a chunk may be sent now, and count it if so.

        size : of the chunk's body, bytes; overhead : bytes that its datagram costs beside the body
        """
        total = size + overhead
        if self._startup_end is not None and now >= self._startup_end:
            self._startup_left = 0
        if self._queue.added_delay(total, now) > MAX_ADDED_DELAY_S:
            return False
        if not (self._consume_startup(total, now) if self.in_startup else self._consume_joint(total, now)):
            return False
        if self._startup_end is None:
            self._startup_end = now + STARTUP_S
        self._queue.add(total, now)
        self.bytes_sent += total
        self._startup_left -= size
        return True

    def _consume_startup(self, total: int, now: float) -> bool:
        if self._chunks.consume(total, now):
            self._link.force_take(total, now)
            return True
        return self._link.consume(total, now)

    def _consume_joint(self, total: int, now: float) -> bool:
        """Take from the chunks' own rate, and from the joint one or, where that is never enough, the least one."""
        if self._chunks.time_until(total, now) > 0:
            return False
        if self._joint.consume(total, now):
            self._least.force_take(total, now)
        elif self._joint.debt(now) >= self._max_debt and self._least.consume(total, now):
            self._joint.force_take(total, now)
        else:
            return False
        return self._chunks.consume(total, now)

    def add_motion(self, size: int, now: float) -> None:
        """Count what else was sent, bytes with headers: the chunks have what it leaves."""
        self._link.force_take(size, now)
        self._joint.force_take(size, now)
        self._queue.add_motion(size, now)
