"""What one end announces of its participant: name, head, camera, whether its portrait may be shown. No I/O, no clock.

Strategy. An announcement rides in a datagram and is repeated until one is acknowledged; then it costs nothing. That the
camera is on again, the motion tells too. While it is off, the announcement is also the keep-alive.
"""

from collections import OrderedDict
from collections.abc import Iterable

from conf.protocol.messages import ParticipantMessage
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.participant.state import CameraState, clean_name
from conf.protocol.wire import encode_body

REPEAT_S = 0.5  # as long as reports take
WAIT_S = 0.1  # a new announcement waits so long for another datagram
KEEP_ALIVE_S = 1.0
MAX_IN_FLIGHT = 64  # datagrams remembered until they are acknowledged


class OutboundParticipant:
    """Announce a participant.

    camera : ON or OFF; is_portrait_withdrawn : whether the images sent of the person are no longer to be shown
    """

    def __init__(self, name: str = "", *, head: int = 0) -> None:
        """head : number of the head that the participant has chosen, 0 for none"""
        self.camera = CameraState.ON
        self.is_portrait_withdrawn = False
        self._name = clean_name(name)
        self._head = head
        self.restart(float("-inf"))

    def restart(self, now: float) -> None:
        """Begin a new session, whose receiver knows nothing: no name, no head, and a camera that is on."""
        self._in_flight: OrderedDict[int, ParticipantMessage] = OrderedDict()  # by datagram counter
        self._is_known = self._message == ParticipantMessage("", CameraState.ON)
        self._sent_at = float("-inf")
        self._alone_due = now + WAIT_S

    def set_camera(self, camera: CameraState, now: float) -> None:
        """Announce a camera that was switched on or off."""
        if camera is not self.camera:
            self.camera = camera
            self._announce(now)

    def set_portrait_withdrawn(self, is_withdrawn: bool, /, now: float) -> None:
        """Announce that the images sent are no longer to be shown, or are again."""
        if is_withdrawn is not self.is_portrait_withdrawn:
            self.is_portrait_withdrawn = is_withdrawn
            self._announce(now)

    @property
    def max_bytes(self) -> int:
        """The bytes of an announcement, with one for a composite."""
        return len(encode_body(self._message)) + 1

    def body(self, now: float) -> OutgoingBody:
        """Return the announcement, which is sent now."""
        self._sent_at = now
        return OutgoingBody(encode_body(self._message), participant=self._message)

    def is_due(self, now: float) -> bool:
        """Return whether the announcement should ride in a datagram."""
        return not self._is_known and now >= self._sent_at + REPEAT_S

    def is_due_alone(self, now: float, sent_at: float) -> bool:
        """Return whether it should be sent although nothing else is. sent_at : when anything was sent last"""
        if self.camera is CameraState.OFF and now >= sent_at + KEEP_ALIVE_S:
            return True
        return self.is_due(now) and now >= self._alone_due

    def on_sent(self, counter: int, outgoing: OutgoingBody) -> None:
        """Record the counter of the datagram in which a body was sent."""
        if outgoing.participant:
            self._in_flight[counter] = outgoing.participant
            if len(self._in_flight) > MAX_IN_FLIGHT:
                self._in_flight.popitem(last=False)

    def on_acknowledged(self, counters: Iterable[int]) -> None:
        """Apply the counters that the receiver has decoded."""
        for counter in counters:
            self._is_known |= self._in_flight.pop(counter, None) is not None

    def _announce(self, now: float) -> None:
        """Announce anew what the receiver may know differently."""
        self.restart(now)
        self._is_known = False

    @property
    def _message(self) -> ParticipantMessage:
        return ParticipantMessage(self._name, self.camera, self.is_portrait_withdrawn, self._head)
