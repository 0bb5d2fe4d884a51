"""Two ends of a call in memory, each with both halves of a leg, a seal, a talking face and a voice of random bytes."""

import heapq
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count

from conf.protocol.call_leg import CallLeg
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.send_leg import SendLeg
from conf.protocol.session.packet import DataPacket, parse_datagram
from conf.protocol.session.seal import OpeningKey, SealingKey
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.voice.formats import VoiceFormat, VoiceFrame, VoicePacket, VoiceState
from tests.support.simulated_calls import talk

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
STEP_S = 1 / 100
WAY_S = 0.04
Motion = Callable[[float], MotionFrame]


@dataclass
class Losses:
    """Losses of a fraction of the datagrams, in bursts of equal length."""

    fraction: float = 0.0
    burst: int = 1
    generator: random.Random = field(default_factory=lambda: random.Random(1))
    _left: int = 0

    def next(self) -> bool:
        """Return whether the next datagram is lost."""
        if self._left == 0 and self.generator.random() < self.fraction / self.burst:
            self._left = self.burst
        is_lost = self._left > 0
        self._left -= is_lost
        return is_lost


class Talker:
    """One end.

    wire : (time, bytes with headers) of all that it has sent; datagrams : the same as bytes; bodies : unsealed
    sent : its voice frames by time; played : the other's
    is_talking : whether its microphone hears somebody; mean_fill : size of a frame of Opus over the nominal one
    """

    def __init__(self, secrets: tuple[bytes, bytes], rate: RateOptions, motion: Motion | None, seed: int) -> None:
        self.random = random.Random(seed)
        self.secret = secrets[0]
        self.send, self.receive = SendLeg(PARAMETERS, 0.0, rate=rate), ReceiveLeg(seed)
        self.sealing_key, self.opening_key = SealingKey(5, secrets[0]), OpeningKey(secrets[1])
        self.leg = CallLeg(send=self.send, receive=self.receive, sealed_bytes=self.sealing_key.sealed_bytes)
        self.send.start(0.0)
        self.motion = motion
        self.is_talking = True
        self.mean_fill, self.spread = 0.85, 0.08
        self.wire: list[tuple[float, int]] = []
        self.datagrams: list[bytes] = []
        self.bodies: list[bytes] = []
        self.sent: dict[float, bytes] = {}
        self.played: list[VoiceFrame] = []
        self._frame_due = self._voice_begin = 0.0

    def capture(self, now: float) -> None:
        """Send the frame and the voice packet that are due."""
        if self.motion and now >= self._frame_due:
            self.send.send_frame(self.motion(self._frame_due), now)
            fps = self.send.motion.profile.fps
            self._frame_due = (round(self._frame_due * fps) + 1) / fps
        voice_format = self.send.voice_format
        if not voice_format or now < self._voice_begin + voice_format.packet_s:
            return
        if self.is_talking:
            packet = VoicePacket(self._voice_begin, voice_format, tuple(self._frames(voice_format)))
            for number, data in enumerate(packet.frames):
                self.sent[round(packet.timestamp + number * voice_format.frame_ms / 1000, 3)] = data
            self.send.send_voice(packet, now)
        else:
            self.send.set_voice_state(VoiceState.SILENT, now, noise_level=60)
        self._voice_begin += voice_format.packet_s

    def seal(self, now: float) -> list[bytes]:
        """Seal what is due."""
        datagrams = []
        for outgoing in self.leg.bodies_to_send(now):
            counter = self.sealing_key.counter
            self.bodies.append(outgoing.body)
            datagrams.append(self.sealing_key.seal(outgoing.body))
            self.leg.on_sent(counter, outgoing, now)
            self.wire.append((now, len(datagrams[-1]) + HEADER_BYTES))
        self.datagrams += datagrams
        return datagrams

    def open(self, data: bytes, now: float) -> None:
        """Receive a datagram."""
        packet = parse_datagram(data)
        assert isinstance(packet, DataPacket)
        counter, body = self.opening_key.open(packet)
        acknowledged = self.leg.receive_body(body, counter, len(data) + HEADER_BYTES, now)
        if acknowledged is not None:
            self.sealing_key.acknowledge(acknowledged)

    def play(self, now: float) -> None:
        """Play what is due."""
        self.played += self.receive.voice.frames_until(self.receive.clock.playhead(now))

    def kbps(self, begin: float, end: float) -> float:
        """Return the mean rate between two times, headers included."""
        return sum(size for at, size in self.wire if begin <= at < end) * 8 / 1000 / (end - begin)

    def max_kbps(self) -> float:
        """Return the highest rate over any ten seconds, headers included."""
        return max(self.kbps(begin, begin + 10) for begin, _ in self.wire)

    @property
    def lost_voice(self) -> float:
        """The fraction of the frames played that were lost."""
        return sum(frame.data is None for frame in self.played) / max(len(self.played), 1)

    def _frames(self, voice_format: VoiceFormat) -> list[bytes]:
        bits = voice_format.frame_bits
        if voice_format.fixed_size:
            values = [self.random.getrandbits(bits) << -bits % 8 for _ in range(voice_format.frames)]
            return [value.to_bytes(-(-bits // 8)) for value in values]
        sizes = (round(self.random.gauss(self.mean_fill, self.spread) * bits / 8) for _ in range(voice_format.frames))
        return [self.random.randbytes(max(1, size)) for size in sizes]


class TwoWayCall:
    """Two talkers and the link between them."""

    def __init__(
        self,
        rate: RateOptions,
        *,
        motions: tuple[Motion | None, Motion | None] = (talk, talk),
        losses: Losses | None = None,
        seed: int = 1,
    ) -> None:
        rng = random.Random(seed)
        secrets = rng.randbytes(32), rng.randbytes(32)
        self.a = Talker(secrets, rate, motions[0], 1)
        self.b = Talker((secrets[1], secrets[0]), rate, motions[1], 2)
        self.losses = losses or Losses()
        self.now = 0.0
        self._in_flight: list[tuple[float, int, Talker, bytes]] = []
        self._order = count()
        self._steps = 0

    def run(self, seconds: float) -> None:
        """Let time pass."""
        end = self.now + seconds
        while self.now < end:
            self._deliver()
            for talker, other in ((self.a, self.b), (self.b, self.a)):
                talker.capture(self.now)
                for data in talker.seal(self.now):
                    if not self.losses.next():
                        heapq.heappush(self._in_flight, (self.now + WAY_S, next(self._order), other, data))
                talker.play(self.now)
            self._steps += 1
            self.now = self._steps * STEP_S

    def _deliver(self) -> None:
        while self._in_flight and self._in_flight[0][0] <= self.now:
            arrival, _, target, data = heapq.heappop(self._in_flight)
            target.open(data, arrival)
