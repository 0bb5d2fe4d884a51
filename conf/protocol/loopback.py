"""A call in simulated time without a network, for measurements. Pure: random bytes are an argument."""

from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.handshake import RandomBytes
from conf.protocol.session.pairing_code import generate_code
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES

SENDER, RECEIVER = ("sender", 1), ("receiver", 2)
ONE_WAY_S = 0.05
HANDSHAKE_S = 2.0  # before the first frame


class LoopbackCall:
    """A connected sender and receiver. Every datagram arrives ONE_WAY_S after it was sent.

    datagrams : sent by the sender since the handshake; sealed_bytes : their size, UDP/IP headers not included
    """

    def __init__(
        self,
        parameters: StreamParameters,
        now: float,
        random: RandomBytes,
        *,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
    ) -> None:
        """random : n -> n random bytes"""
        code, time = generate_code(random), now - HANDSHAKE_S
        self.receiver = ReceiverEndpoint(SessionServer(code, random))
        session = SenderSession(code, RECEIVER, random, time)
        self.sender = SenderConnection(session, parameters, time, rate=rate, portrait=portrait)
        self._replies: list[tuple[float, bytes]] = []  # (arrival, datagram)
        self.datagrams = self.sealed_bytes = 0
        while not self.sender.status(now).connected:
            self.exchange(time)
            time += 2 * ONE_WAY_S
        self.datagrams = self.sealed_bytes = 0

    @property
    def stream(self) -> ReceiveLeg:
        """The receiving half of the call."""
        return next(iter(self.receiver.streams.values()))

    @property
    def wire_bytes(self) -> int:
        """Bytes sent since the handshake, headers included."""
        return self.sealed_bytes + HEADER_BYTES * self.datagrams

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Deliver the replies that have arrived by now, and send one frame."""
        self.sender.send_frame(frame, now)
        self.exchange(now)

    def exchange(self, now: float) -> None:
        """Deliver the replies that have arrived by now, and send what is due."""
        for arrival, data in [reply for reply in self._replies if reply[0] <= now]:
            self.sender.receive_datagram(data, RECEIVER, arrival)
        self._replies = [reply for reply in self._replies if reply[0] > now]
        for data, _ in self.sender.datagrams_to_send(now):
            self.datagrams += 1
            self.sealed_bytes += len(data)
            self.receiver.receive_datagram(data, SENDER, now + ONE_WAY_S)
        replies = self.receiver.datagrams_to_send(now + ONE_WAY_S)
        self._replies += [(now + 2 * ONE_WAY_S, data) for data, _ in replies]
