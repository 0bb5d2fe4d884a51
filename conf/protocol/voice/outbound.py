"""The outgoing voice stream: packets of encoded frames in, message bodies out. No codec, no I/O, no clock.

Strategy. A format gets a number that stands in each packet; what the number means goes along with every packet until
the receiver has acknowledged it, so that a lost datagram costs no more than its own voice. Packets follow each other
without a gap on the stream clock while somebody talks; one that does not follow another says so. That nobody talks any
more is announced until it is acknowledged; that somebody talks again, the packets tell.
"""

from collections import OrderedDict
from collections.abc import Iterable

from conf.protocol.messages import VoiceFormatMessage, VoicePayload, VoiceStateMessage
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.stream_clocks import StreamClock
from conf.protocol.voice.formats import GRID_MS, MAX_FORMATS, MAX_NOISE_LEVEL, VoiceFormat, VoicePacket, VoiceState
from conf.protocol.voice.packing import pack_frames
from conf.protocol.wire import encode_body

GRID_S = GRID_MS / 1000
MAX_JITTER_S = 0.03  # of capture times: packets closer than this to the end of the last one follow it without a gap
NOISE_TOLERANCE = 3  # dB: a smaller change of the background noise is not announced
STATE_REPEAT_S = 1.0  # a state that is not acknowledged is sent in a datagram of its own, if there is no other
STATE_WAIT_S = (
    0.1  # a new state waits so long for another datagram, but not the end of talk: the receiver expects voice
)
MAX_IN_FLIGHT = 256  # datagrams remembered until they are acknowledged
MAX_QUEUED = 4  # packets; older ones are dropped


class OutboundVoice:
    """Turn the encoded voice of one sender into message bodies.

    state : what the microphone does
    """

    def __init__(self, clock: StreamClock | None = None) -> None:
        """clock : shared with the motion of the same sender"""
        self.state = VoiceState.OFF
        self._clock = clock or StreamClock()
        self._numbers: OrderedDict[VoiceFormat, int] = OrderedDict()  # by format, the least recently used first
        self._noise_level = MAX_NOISE_LEVEL
        self.restart()

    def restart(self) -> None:
        """Begin a new session, whose receiver knows nothing."""
        self._clock.restart()
        self._numbers.clear()
        self._queue: list[tuple[VoiceFormat, bytes]] = []
        self._previous: VoicePacket | None = None
        self._end: int | None = None  # of the previous packet, units of GRID_MS
        self._in_flight: OrderedDict[int, OutgoingBody] = OrderedDict()  # by datagram counter
        self._acknowledged_formats: set[VoiceFormatMessage] = set()
        self._announcement: VoiceStateMessage | None = None  # a state that the receiver may not know
        if self.state not in (VoiceState.OFF, VoiceState.TALKING):  # the receiver assumes one, packets tell the other
            self._announcement = VoiceStateMessage(self.state, self._noise_level)
        self._announcement_due = float("-inf")

    @property
    def has_packet(self) -> bool:
        """Whether a packet waits to be sent."""
        return bool(self._queue)

    @property
    def waiting_bytes(self) -> int:
        """Bytes of the packets that wait, with a byte for a composite each."""
        return sum(len(body) + 1 for _, body in self._queue)

    def set_state(self, state: VoiceState, noise_level: int, now: float) -> None:
        """Announce what the microphone does. noise_level : of the background noise, -dBFS, 0 to 127"""
        noise_level = min(max(noise_level, 0), MAX_NOISE_LEVEL)
        changed, talk_ends = state is not self.state, self.state is VoiceState.TALKING
        louder_or_softer = abs(noise_level - self._noise_level) >= NOISE_TOLERANCE
        self.state = state
        if state is VoiceState.TALKING:
            self._announcement = None
        elif changed or (state is VoiceState.SILENT and louder_or_softer):
            self._end = self._previous = None
            self._noise_level = noise_level
            self._announcement = VoiceStateMessage(state, noise_level)
            self._announcement_due = now if talk_ends else now + STATE_WAIT_S

    def send(self, packet: VoicePacket) -> int:
        """Send a packet, which means that somebody talks; one captured before the stream's clock starts is dropped.

        Returns the bytes of its data. Raises ValueError if its frames are not as many and as long as its format says.
        """
        packet.format.check()
        if len(packet.frames) != packet.format.frames:
            raise ValueError(f"a packet of this format has {packet.format.frames} frames, not {len(packet.frames)}")
        stream_time = self._clock.offset(packet.timestamp)
        number = round(stream_time / GRID_S)
        is_next = self._end is not None and abs(stream_time - self._end * GRID_S) <= MAX_JITTER_S
        if self._end is not None and (is_next or number < self._end):
            number = self._end
        if number < 0:
            return 0
        self.state, self._announcement = VoiceState.TALKING, None
        continues = is_next and self._previous is not None and self._previous.format == packet.format
        previous = self._previous.frames if continues and self._previous else ()
        repeated = previous[len(previous) - packet.format.repeated :] if previous else ()
        data = pack_frames((*packet.frames, *repeated), packet.format)
        payload = VoicePayload(number, not continues, self._number_of(packet.format), data)
        self._queue = [*self._queue, (packet.format, encode_body(payload))][-MAX_QUEUED:]
        self._end, self._previous = number + packet.format.packet_ms // GRID_MS, packet
        return len(data)

    def drain(self) -> list[OutgoingBody]:
        """Return the packets to send, with the formats that the receiver may not know, and empty the queue."""
        queue, self._queue = self._queue, []
        bodies = []
        for voice_format in dict.fromkeys(voice_format for voice_format, _ in queue):
            message = VoiceFormatMessage(self._number_of(voice_format), voice_format)
            if message not in self._acknowledged_formats:
                bodies.append(OutgoingBody(encode_body(message), voice_format=message))
        return bodies + [OutgoingBody(body) for _, body in queue]

    def state_bodies(self, now: float, *, alone: bool) -> list[OutgoingBody]:
        """Return the state if the receiver may not know it. alone : there is no other body to send it with"""
        announcement = self._announcement
        if announcement is None or (alone and now < self._announcement_due):
            return []
        self._announcement_due = now + STATE_REPEAT_S
        return [OutgoingBody(encode_body(announcement), voice_state=announcement)]

    def on_sent(self, counter: int, outgoing: OutgoingBody) -> None:
        """Record the counter of the datagram in which a body was sent."""
        if outgoing.voice_format or outgoing.voice_state:
            self._in_flight[counter] = outgoing
            if len(self._in_flight) > MAX_IN_FLIGHT:
                self._in_flight.popitem(last=False)

    def on_acknowledged(self, counters: Iterable[int]) -> None:
        """Apply the counters that the receiver has decoded."""
        for counter in counters:
            outgoing = self._in_flight.pop(counter, None)
            if outgoing is None:
                continue
            if outgoing.voice_format:
                self._acknowledged_formats.add(outgoing.voice_format)
            if outgoing.voice_state is self._announcement:  # not one like it that was announced earlier
                self._announcement = None

    def _number_of(self, voice_format: VoiceFormat) -> int:
        """Return the number of a format, if need be that of the one not used for longest."""
        if voice_format not in self._numbers:
            number = len(self._numbers)
            if number == MAX_FORMATS:
                _, number = self._numbers.popitem(last=False)
                self._acknowledged_formats = {m for m in self._acknowledged_formats if m.format_number != number}
            self._numbers[voice_format] = number
        self._numbers.move_to_end(voice_format)
        return self._numbers[voice_format]
