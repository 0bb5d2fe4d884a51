"""The side of a call that calls: its session and its leg, in the shape of aioquic. No I/O, no clock."""

from collections import deque
from collections.abc import Sequence

from conf.protocol.address import Address
from conf.protocol.call_leg import CallLeg
from conf.protocol.messages import Bye, MotionFrame, StreamParameters
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.send_leg import LinkStatus, SendLeg
from conf.protocol.session.call_session import CallSession
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import AddressChanged, BodyReceived, Connected, Event, LossReason, SessionEnded
from conf.protocol.statistics import HEADER_BYTES, RateWindow
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.wire import encode_body

FAREWELL = encode_body(Bye())


class SenderConnection:
    """One sender's call; CallEndpoint receives too.

    outbound : the outgoing motion stream; traffic : bytes sent, headers included
    """

    def __init__(
        self,
        session: SenderSession | CallSession,
        parameters: StreamParameters,
        now: float,
        *,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
        name: str = "",
        head: int = 0,
    ) -> None:
        """Prepare a call.

        portrait : the objects of the sender's portrait, None to send none
        name : of the participant, "" for none; head : number of the head that it has chosen, 0 for none
        """
        self.traffic = RateWindow()
        self._session = session
        self._send = SendLeg(parameters, now, rate=rate, portrait=portrait, name=name, head=head)
        self._leg = CallLeg(send=self._send, sealed_bytes=session.sealed_bytes)
        self.outbound = self._send.motion
        self._events: deque[Event] = deque()

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Send one frame; it is dropped while there is no session."""
        self._send.send_frame(frame, now)

    def send_no_face(self, timestamp: float, now: float) -> None:
        """Report that there is no face at `timestamp`."""
        self._send.send_no_face(timestamp, now)

    def send_camera_off(self, now: float) -> None:
        """Announce that the camera is off. Nothing of the face is sent until the next frame, or report of no face."""
        self._send.send_camera_off(now)

    def set_portrait_allowed(self, is_allowed: bool, /, now: float) -> None:
        """Announce whether the images sent of the person may be shown."""
        self._send.set_portrait_allowed(is_allowed, now)

    @property
    def voice_format(self) -> VoiceFormat | None:
        """The format to encode voice in now. None: voice is off, the limit has no room, or there is no session."""
        return self._send.voice_format

    @property
    def voice_state(self) -> VoiceState:
        """What the microphone does, as the receiver is told."""
        return self._send.voice.state

    def send_voice(self, packet: VoicePacket, now: float) -> None:
        """Send encoded voice, which means that somebody talks; it is dropped while there is no session."""
        self._send.send_voice(packet, now)

    def set_voice_state(self, state: VoiceState, now: float, *, noise_level: int = 127) -> None:
        """Announce what the microphone does. noise_level : of the background noise, -dBFS, 0 to 127"""
        self._send.set_voice_state(state, now, noise_level=noise_level)

    def receive_datagram(self, data: bytes, address: Address, now: float) -> None:
        """Process a datagram, whatever its bytes."""
        self._session.receive_datagram(data, address, now)
        self._process_events(len(data) + HEADER_BYTES, now)

    def datagrams_to_send(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams to send now: the handshake's and the sealed bodies."""
        budget = self._send.budget
        datagrams = [d for d in self._session.datagrams_to_send(now) if budget.consume(len(d[0]) + HEADER_BYTES, now)]
        self._process_events(0, now)
        datagrams += self._seal(self._leg.bodies_to_send(now), now)
        budget.on_datagrams_sent(self._count(datagrams, now), now)
        return datagrams

    def close(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams that end the call."""
        datagrams = self._seal(self._leg.closing_bodies(now), now)
        self._count(datagrams, now)
        return datagrams

    @property
    def is_unheard(self) -> bool:
        """Whether the peer hears nothing of what this end sends over a relay."""
        return self._session.is_unheard

    def set_candidates(self, addresses: Sequence[Address]) -> None:
        """Announce the addresses at which this end may be reached directly, in a session over a relay."""
        self._session.set_candidates(addresses)

    def next_event(self) -> Event | None:
        """Return the oldest event not returned yet."""
        return self._events.popleft() if self._events else None

    def status(self, now: float) -> LinkStatus:
        """Return the state of the link."""
        return self._send.status(now)

    def _process_events(self, wire_bytes: int, now: float) -> None:
        """Apply the session's events. wire_bytes : of the datagram in which a body arrived"""
        while event := self._session.next_event():
            if isinstance(event, BodyReceived):
                self._receive_body(event, wire_bytes, now)
                continue
            self._apply(event, now)
            self._events.append(event)

    def _receive_body(self, event: BodyReceived, wire_bytes: int, now: float) -> None:
        if (acknowledged := self._leg.receive_body(event.body, event.counter, wire_bytes, now)) is not None:
            self._session.acknowledge(acknowledged)
        if self._leg.ended:
            self._session.close(LossReason.HUNG_UP, farewell=FAREWELL)

    def _apply(self, event: Event, now: float) -> None:
        match event:
            case Connected(session=session):
                stream = self._new_stream(session)
                self._leg = CallLeg(send=self._send, receive=stream, sealed_bytes=self._session.sealed_bytes)
                self._send.start(now)
            case AddressChanged():
                self._send.on_path_changed()
            case SessionEnded():
                self._send.stop()

    def _new_stream(self, session: int) -> ReceiveLeg | None:
        """Return the receiving half of a new session: none, as this end only sends."""
        return None

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
