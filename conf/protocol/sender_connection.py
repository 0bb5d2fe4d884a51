"""The sender's side of a call: its session and its sending half, in the shape of aioquic. No I/O, no clock."""

from collections import deque

from conf.protocol.address import Address
from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.motion.outbound import OutgoingBody
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.send_budget import RateOptions
from conf.protocol.send_leg import LinkStatus, SendLeg
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import BodyReceived, Connected, Event, SessionEnded
from conf.protocol.statistics import HEADER_BYTES, RateWindow


class SenderConnection:
    """One sender's call.

    outbound : the outgoing motion stream; traffic : bytes sent, headers included
    """

    def __init__(
        self,
        session: SenderSession,
        parameters: StreamParameters,
        now: float,
        *,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
    ) -> None:
        """portrait : the objects of the sender's portrait, None to send none"""
        self.traffic = RateWindow()
        self._session = session
        self._leg = SendLeg(parameters, now, rate=rate, portrait=portrait)
        self.outbound = self._leg.motion
        self._events: deque[Event] = deque()

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Send one frame; it is dropped while there is no session."""
        self._leg.send_frame(frame, now)

    def send_no_face(self, timestamp: float, now: float) -> None:
        """Report that there is no face at `timestamp`."""
        self._leg.send_no_face(timestamp, now)

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Process a datagram, whatever its bytes."""
        self._session.receive_datagram(data, address, now)
        self._process_events(now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams to send now: the handshake's and the sealed bodies."""
        budget = self._leg.budget
        datagrams = [d for d in self._session.datagrams_to_send(now) if budget.take(len(d[0]) + HEADER_BYTES, now)]
        self._process_events(now)
        datagrams += self._seal(self._leg.bodies_to_send(now), now)
        budget.on_datagrams_sent(self._count(datagrams, now), now)
        return datagrams

    def close(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams that end the call."""
        datagrams = self._seal(self._leg.closing_bodies(now), now)
        self._count(datagrams, now)
        return datagrams

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        return self._events.popleft() if self._events else None

    def status(self, now: float) -> LinkStatus:
        """Return the state of the link."""
        return self._leg.status(now)

    def _process_events(self, now: float) -> None:
        while event := self._session.next_event():
            match event:
                case BodyReceived(body=body):
                    if (counter := self._leg.receive_body(body, now)) is not None:
                        self._session.acknowledge(counter)
                    continue
                case Connected():
                    self._leg.start(now)
                case SessionEnded():
                    self._leg.stop()
            self._events.append(event)

    def _seal(self, bodies: list[OutgoingBody], now: float) -> list[tuple[bytes, Address]]:
        datagrams = []
        for outgoing in bodies:
            if sealed := self._session.seal_body(outgoing.body):
                self._leg.on_sent(sealed.counter, outgoing, now)
                datagrams.append((sealed.datagram, sealed.address))
        return datagrams

    def _count(self, datagrams: list[tuple[bytes, Address]], now: float) -> int:
        """Count datagrams in `traffic`. Returns their bytes, headers included."""
        sizes = [len(data) + HEADER_BYTES for data, _ in datagrams]
        for size in sizes:
            self.traffic.add(size, now)
        return sum(sizes)
