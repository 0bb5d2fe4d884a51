"""The sending half without I/O: motion in, datagrams out. Time is an argument, sockets live in sender/udp.py."""

from conf.protocol.messages import KeepAlive, MotionFrame, Presence, StreamParameters
from conf.protocol.statistics import HEADER_BYTES, RateWindow
from conf.protocol.wire import Datagram, Message, encode

PARAMETERS_EVERY_S = 1.0
KEEP_ALIVE_EVERY_S = 1.0


class Outbound:
    """Turn motion frames into datagrams, with the stream's parameters in between and keep-alives in silence."""

    def __init__(self, parameters: StreamParameters) -> None:
        self.parameters = parameters
        self.frames_sent = 0
        self.traffic = RateWindow()
        self._sequence = 0
        self._pending: list[bytes] = []
        self._parameters_due = float("-inf")
        self._sent_at = float("-inf")

    def send_frame(self, frame: MotionFrame, now: float) -> None:
        """Queue one frame's motion."""
        self._queue_parameters(now)
        self._queue(frame, now)
        self.frames_sent += 1

    def send_absence(self, timestamp: float, now: float) -> None:
        """Note that there is no face at `timestamp`: a keep-alive goes out when nothing else has for a while."""
        if now - self._sent_at >= KEEP_ALIVE_EVERY_S:
            self._queue_parameters(now)
            self._queue(KeepAlive(timestamp, Presence.NO_FACE), now)

    def datagrams_to_send(self, now: float) -> list[bytes]:
        """Take what is to be sent now."""
        pending, self._pending = self._pending, []
        for data in pending:
            self.traffic.add(len(data) + HEADER_BYTES, now)
        return pending

    def _queue_parameters(self, now: float) -> None:
        if now >= self._parameters_due:
            self._parameters_due = now + PARAMETERS_EVERY_S
            self._queue(self.parameters, now)

    def _queue(self, message: Message, now: float) -> None:
        self._pending.append(encode(Datagram(self._sequence, message)))
        self._sequence += 1
        self._sent_at = now
