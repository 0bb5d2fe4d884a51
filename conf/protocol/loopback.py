"""A call without a network: caller and host in one place, in simulated time. For measuring, not for showing."""

import os

from conf.protocol.messages import MotionFrame, StreamParameters
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.portrait import ObjectSender
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.sender_connection import RateOptions, SenderConnection
from conf.protocol.session.client import SenderSession
from conf.protocol.session.pairing_code import generate_code
from conf.protocol.session.server import SessionServer
from conf.protocol.statistics import HEADER_BYTES

SENDER, RECEIVER = ("sender", 1), ("receiver", 2)
ONE_WAY_S = 0.05
MOST_STEPS = 20  # of a handshake without losses


class LoopbackCall:
    """Every datagram arrives, ONE_WAY_S after it was sent.

    datagrams : how many the sender has sent since the handshake
    sealed_bytes : what they held, UDP/IP headers not counted
    """

    def __init__(
        self,
        parameters: StreamParameters,
        now: float,
        *,
        link: RateOptions | None = None,
        portrait: ObjectSender | None = None,
    ) -> None:
        code = generate_code(os.urandom)
        begin = now - MOST_STEPS * 2 * ONE_WAY_S  # so that the handshake is over when the first frame comes
        self.host = ReceiverEndpoint(SessionServer(code, os.urandom))
        self.caller = SenderConnection(
            SenderSession(code, RECEIVER, os.urandom, begin), parameters, begin, link=link, portrait=portrait
        )
        self._answers: list[tuple[float, bytes]] = []
        self.datagrams = self.sealed_bytes = 0
        for step in range(MOST_STEPS):
            if not self.caller.status(now).connected:
                self._exchange(begin + step * 2 * ONE_WAY_S)
        self.datagrams = self.sealed_bytes = 0

    @property
    def inbound(self) -> InboundMotion:
        """What the host has of the call."""
        return next(iter(self.host.streams.values()))

    @property
    def wire_bytes(self) -> int:
        """What was sent since the handshake, headers counted."""
        return self.sealed_bytes + HEADER_BYTES * self.datagrams

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Send one frame; what has come back by now is taken first."""
        self.caller.send_frame(frame, now)
        self._exchange(now)

    def _exchange(self, now: float) -> None:
        self._deliver_replies(now)
        for data, _ in self.caller.datagrams_to_send(now):
            self.datagrams += 1
            self.sealed_bytes += len(data)
            self.host.receive_datagram(data, SENDER, now + ONE_WAY_S)
        answers = self.host.datagrams_to_send(now + ONE_WAY_S)
        self._answers += [(now + 2 * ONE_WAY_S, data) for data, _ in answers]

    def _deliver_replies(self, now: float) -> None:
        due = [answer for answer in self._answers if answer[0] <= now]
        self._answers = [answer for answer in self._answers if answer[0] > now]
        for arrival, data in due:
            self.caller.receive_datagram(data, RECEIVER, arrival)
