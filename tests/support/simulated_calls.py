"""Calls in memory and in simulated time: senders, a receiver, and a network of seeded losses, delays and jitter."""

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import count

import numpy as np

from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import Connected, Event
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from tests.support.simulated_sessions import CODE, RECEIVER, Network
from tests.support.synthetic_motion import talking

PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
STEP_S = 1 / 60
Motion = Callable[[float], MotionFrame | None]
Datagrams = list[tuple[bytes, Address]]
FACES = talking(47 * 360)


def talk(timestamp: float) -> MotionFrame:
    """Return the talking face of tests/support/synthetic_motion.py at any time, interpolated between its frames."""
    tick, weight = divmod(timestamp * 15, 1)
    a, b = FACES[int(tick) % len(FACES)], FACES[int(tick + 1) % len(FACES)]
    return MotionFrame(
        timestamp,
        np.float32(1.4) * (a.displacements + np.float32(weight) * (b.displacements - a.displacements)),
        a.pose + weight * (b.pose - a.pose),
    )


def frown(timestamp: float) -> MotionFrame:
    """Return the talking face, which frowns for one and a half of four seconds, never twice alike."""
    phase = timestamp % 4.0
    depth = min(max(4 * min(phase, 1.5 - phase), 0.0), 1.0)
    return replace(talk(timestamp), furrow=depth * (0.8 + 0.2 * float(np.sin(7 * timestamp))))


def no_face(_timestamp: float) -> None:
    """Return the motion of an empty chair."""


def make_receiver(code: str = CODE, seed: object = 1) -> ReceiverEndpoint:
    """Return a receiver that knows nothing."""
    return ReceiverEndpoint(SessionServer(code, random.Random(f"receiver {seed}").randbytes))


@dataclass
class Line:
    """Both directions of one sender's network.

    loss : fraction lost; delay_s, jitter_s : each datagram takes delay + up to jitter; down : everything is lost
    """

    loss: float = 0.0
    delay_s: float = 0.04
    jitter_s: float = 0.0
    down: bool = False
    generator: random.Random = field(default_factory=lambda: random.Random(1))

    def delay(self) -> float | None:
        """Return the delay of one datagram, None if it is lost."""
        lost = self.generator.random() < self.loss
        delay = self.delay_s + self.generator.random() * self.jitter_s
        return None if lost or self.down else delay


class SimulatedSender:
    """A sender with a simulated camera.

    motion : what the camera captures; a motion of None is no face, None captures nothing
    is_on : whether it sends at all
    wire : (time, bytes with headers) of all that it has sent
    shown : (time, frame, age) of each frame that the receiver has drawn
    frames : what was captured, by timestamp, the newest at `captured`
    origin : timestamp of the session's first frame, where the stream's clock starts
    """

    def __init__(
        self,
        now: float,
        *,
        code: str = CODE,
        address: Address = ("198.51.100.1", 40000),
        motion: Motion | None = talk,
        line: Line | None = None,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
        seed: object = 1,
    ) -> None:
        self.session = SenderSession(code, RECEIVER, random.Random(f"{address} {seed}").randbytes, now)
        self.connection = SenderConnection(self.session, PARAMETERS, now, rate=rate, portrait=portrait)
        self.address = address
        self.motion = motion
        self.line = line or Line()
        self.is_on = True
        self.wire: list[tuple[float, int]] = []
        self.events: list[Event] = []
        self.shown: list[tuple[float, MotionFrame, float]] = []
        self.frames: dict[float, MotionFrame] = {}
        self.captured = -1.0
        self.origin = 0.0
        self._began = now
        self._is_first_frame = True

    def datagrams_to_send(self, now: float) -> Datagrams:
        """Capture a frame if one is due, and return what is to be sent."""
        if not self.is_on:
            return []
        while event := self.connection.next_event():
            self.events.append(event)
            self._is_first_frame |= isinstance(event, Connected)
        if self.motion is not None and self.connection.status(now).connected:
            self._capture(self.motion, now)
        return self.connection.datagrams_to_send(now)

    def receive(self, datagrams: Datagrams, now: float) -> None:
        """Receive those datagrams that are addressed to this sender."""
        for data, address in datagrams:
            if address == self.address:
                self.connection.receive_datagram(data, RECEIVER, now)

    def _capture(self, motion: Motion, now: float) -> None:
        fps = self.connection.outbound.profile.fps
        timestamp = int((now - self._began) * fps) / fps
        if timestamp <= self.captured:
            return
        self.captured = timestamp
        if self._is_first_frame:
            self.origin, self._is_first_frame = timestamp, False
        frame = motion(timestamp)
        if frame is None:
            self.connection.send_no_face(timestamp, now)
        else:
            self.frames[timestamp] = frame
            self.connection.send_frame(frame, now)


def exchange(receiver: ReceiverEndpoint, sender: SimulatedSender, begin: float, seconds: float) -> float:
    """Exchange datagrams without loss or delay for some seconds, 20 ms a step. Returns the time after it."""
    now = begin
    for step in range(int(seconds / 0.02)):
        now = begin + step * 0.02
        for data, _ in sender.datagrams_to_send(now):
            receiver.receive_datagram(data, sender.address, now)
        sender.receive(receiver.datagrams_to_send(now), now)
    return now


class World:
    """Run all timers, frames and datagrams. `traffic` : (time, source, target, bytes) of all datagrams."""

    def __init__(self, *, code: str = CODE, seed: object = 1) -> None:
        self.now = 1000.0
        self.seed = seed
        self.receiver = make_receiver(code, seed)
        self.senders: list[SimulatedSender] = []
        self.events: list[Event] = []
        self.traffic: list[tuple[float, Address, Address, bytes]] = []
        self._network = Network()
        self._calls = count(1)

    def call(
        self,
        *,
        code: str = CODE,
        motion: Motion | None = talk,
        line: Line | None = None,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
    ) -> SimulatedSender:
        """Add a sender."""
        address: Address = (f"198.51.100.{next(self._calls)}", 40000)
        sender = SimulatedSender(
            self.now, code=code, address=address, motion=motion, line=line, rate=rate, portrait=portrait, seed=self.seed
        )
        self.senders.append(sender)
        return sender

    def restart_receiver(self, *, code: str = CODE) -> None:
        """Replace the receiver by one that knows nothing."""
        self.receiver = make_receiver(code, f"restarted {self.seed}")

    def stream(self, sender: SimulatedSender) -> ReceiveLeg:
        """Return what the receiver has of a sender."""
        assert sender.session.session is not None
        return self.receiver.streams[sender.session.session]

    def run(self, seconds: float) -> None:
        """Let time pass."""
        stop = self.now + seconds
        while self.now < stop:
            self._deliver()
            for sender in self.senders:
                self.send(sender.datagrams_to_send(self.now), sender.address)
            self.send(self.receiver.datagrams_to_send(self.now), RECEIVER)
            self.events += iter(self.receiver.next_event, None)
            self._draw()
            self.now += STEP_S

    def run_until(self, condition: Callable[[], bool], limit: float) -> float:
        """Let time pass until the condition holds; return how long it took. Fails beyond `limit` seconds."""
        began = self.now
        while not condition():
            assert self.now < began + limit
            self.run(STEP_S)
        return self.now - began

    def send(self, datagrams: Datagrams, source: Address) -> None:
        """Put datagrams on the network."""
        for data, target in datagrams:
            self.traffic.append((self.now, source, target, data))
            sender = next((s for s in self.senders if s.address in (source, target)), None)
            if sender is None:
                continue
            if source == sender.address:
                sender.wire.append((self.now, len(data) + HEADER_BYTES))
            delay = sender.line.delay()
            if delay is not None:
                self._network.put(self.now + delay, source, target, data)

    def _deliver(self) -> None:
        for arrival, source, target, data in self._network.arrivals(self.now):
            if target == RECEIVER:
                self.receiver.receive_datagram(data, source, arrival)
            for sender in self.senders:
                sender.receive([(data, target)], arrival)

    def _draw(self) -> None:
        for sender in self.senders:
            number = sender.session.session
            leg = None if number is None else self.receiver.streams.get(number)
            playout = leg.motion.frame_at(self.now) if leg else None
            if playout:
                sender.shown.append((self.now, playout.frame, playout.age_s))
