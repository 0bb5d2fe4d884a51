"""A host, its callers and the network between them, in memory and in simulated time: seeded losses, delays, jitter."""

import heapq
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import RateOptions, SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import Connected, Event
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES
from tests.support.synthetic_motion import talking

CODE = "acorn-tulip-river-42"
WRONG = "acorn-tulip-river-43"
RECEIVER: Address = ("192.0.2.1", 5005)
PARAMETERS = StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1))
STEP_S = 1 / 60
Motion = Callable[[float], MotionFrame]
FACES = talking(47 * 360)


def talk(timestamp: float) -> MotionFrame:
    """Return the talking face of tests/support/synthetic_motion.py at any time, in between its frames too."""
    tick, share = divmod(timestamp * 15, 1)
    a, b = FACES[int(tick) % len(FACES)], FACES[int(tick + 1) % len(FACES)]
    return MotionFrame(
        timestamp,
        np.float32(1.4) * (a.displacements + np.float32(share) * (b.displacements - a.displacements)),
        a.pose + share * (b.pose - a.pose),
    )


@dataclass
class Line:
    """Both ways of one caller's network.

    loss : share lost; delay_s, jitter_s : for each datagram delay + up to jitter; down : nothing passes
    """

    loss: float = 0.0
    delay_s: float = 0.04
    jitter_s: float = 0.0
    down: bool = False
    chance: random.Random = field(default_factory=lambda: random.Random(1))

    def fate(self) -> float | None:
        """Return the delay of one datagram, None if it is lost."""
        lost = self.chance.random() < self.loss
        delay = self.delay_s + self.chance.random() * self.jitter_s
        return None if lost or self.down else delay


@dataclass
class End:
    """A caller as the world sees it.

    wire : (time, bytes with headers) of all that it has sent
    shown : (time, frame, stale) of each picture
    frames : what was captured, by timestamp, the newest at `captured`
    origin : timestamp of the session's first frame, where the stream's clock starts
    """

    caller: SenderConnection
    address: Address
    motion: Motion | None
    line: Line
    began: float
    wire: list[tuple[float, int]] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    shown: list[tuple[float, MotionFrame, float]] = field(default_factory=list)
    frames: dict[float, MotionFrame] = field(default_factory=dict)
    captured: float = -1.0
    origin: float = 0.0
    fresh: bool = True


class World:
    """Run everybody's timers, frames and datagrams. `traffic` : (time, source, target, bytes) of all datagrams."""

    def __init__(self, *, code: str = CODE, seed: object = 1) -> None:
        self.now = 1000.0
        self.seed = seed
        self.host = ReceiverEndpoint(SessionServer(code, random.Random(f"host {seed}").randbytes))
        self.ends: list[End] = []
        self.events: list[Event] = []
        self.traffic: list[tuple[float, Address, Address, bytes]] = []
        self._flying: list[tuple[float, int, Address, Address, bytes]] = []
        self._order = count()

    def call(
        self,
        *,
        code: str = CODE,
        motion: Motion | None = talk,
        line: Line | None = None,
        link: RateOptions | None = None,
    ) -> End:
        """Add a caller."""
        address: Address = (f"198.51.100.{len(self.ends) + 1}", 40000)
        session = SenderSession(code, RECEIVER, random.Random(f"{address} {self.seed}").randbytes, self.now)
        caller = SenderConnection(session, PARAMETERS, self.now, link=link)
        self.ends.append(End(caller, address, motion, line or Line(), self.now))
        return self.ends[-1]

    def restart_host(self, *, code: str = CODE) -> None:
        """Replace the host by one that knows nothing."""
        self.host = ReceiverEndpoint(SessionServer(code, random.Random(f"restarted {self.seed}").randbytes))

    def inbound(self, end: End) -> InboundMotion:
        """Return what the host has of a caller."""
        session = end.caller._session.session
        assert session is not None
        return self.host.streams[session]

    def run(self, seconds: float) -> None:
        """Let time pass."""
        stop = self.now + seconds
        while self.now < stop:
            self._deliver()
            for end in self.ends:
                self._note_events(end)
                self._capture(end)
                self._send(end.caller.datagrams_to_send(self.now), end.address)
            self._send(self.host.datagrams_to_send(self.now), RECEIVER)
            self.events += iter(self.host.next_event, None)
            self._show()
            self.now += STEP_S

    def run_until(self, condition: Callable[[], bool], limit: float) -> float:
        """Let time pass until the condition holds; return how long it took. Fails beyond `limit` seconds."""
        began = self.now
        while not condition():
            assert self.now < began + limit
            self.run(STEP_S)
        return self.now - began

    def _note_events(self, end: End) -> None:
        while event := end.caller.next_event():
            end.events.append(event)
            end.fresh |= isinstance(event, Connected)

    def _capture(self, end: End) -> None:
        if end.motion is None or not end.caller.status(self.now).connected:
            return
        fps = end.caller.outbound.profile.fps
        tick = int((self.now - end.began) * fps)
        if tick / fps > end.captured:
            end.captured = tick / fps
            end.frames[end.captured] = end.motion(end.captured)
            end.origin, end.fresh = (end.captured if end.fresh else end.origin), False
            end.caller.send_frame(end.frames[end.captured], self.now)

    def _send(self, datagrams: list[tuple[bytes, Address]], source: Address) -> None:
        for data, target in datagrams:
            self.traffic.append((self.now, source, target, data))
            end = next((e for e in self.ends if e.address in (source, target)), None)
            if end is None:
                continue
            if source == end.address:
                end.wire.append((self.now, len(data) + HEADER_BYTES))
            delay = end.line.fate()
            if delay is not None:
                heapq.heappush(self._flying, (self.now + delay, next(self._order), source, target, data))

    def _deliver(self) -> None:
        while self._flying and self._flying[0][0] <= self.now:
            arrival, _, source, target, data = heapq.heappop(self._flying)
            if target == RECEIVER:
                self.host.receive_datagram(data, source, arrival)
            for end in self.ends:
                if target == end.address:
                    end.caller.receive_datagram(data, source, arrival)

    def _show(self) -> None:
        for end in self.ends:
            inbound = self.host.streams.get(-1 if (number := end.caller._session.session) is None else number)
            playout = inbound.frame_at(self.now) if inbound else None
            if playout:
                end.shown.append((self.now, playout.frame, playout.age_s))
