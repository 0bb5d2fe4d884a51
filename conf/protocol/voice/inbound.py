"""The incoming voice stream: message bodies in, encoded frames out in order of time. No codec, no I/O, no clock.

Strategy. Frames are stored by their time on the stream clock until the playhead takes them. What is missing between two
frames is lost, unless the later one begins a talk spurt: then nobody talked. After the newest frame the voice goes on,
lost, until the sender says that nobody talks or too much is missing. A packet may repeat the last frames of the one
before it, which fill a gap if they come in time.
"""

from conf.errors import ProtocolError
from conf.protocol.messages import VoiceFormatMessage, VoicePayload, VoiceStateMessage
from conf.protocol.session.sequence import unwrap
from conf.protocol.stream_clocks import Medium, PeerStreamClock, PlayoutClock
from conf.protocol.voice.formats import GRID_MS, MAX_NOISE_LEVEL, VoiceFormat, VoiceFrame, VoiceState
from conf.protocol.voice.packing import unpack_frames
from conf.protocol.wire import VOICE_NUMBER_BITS

MAX_FRAMES = 512  # stored: bounds the memory whatever a peer sends
MAX_GAP_MS = 1000  # a longer gap counts as silence: nothing can conceal it


class InboundVoice:
    """Order the voice of one sender.

    clock : when each frame is due; shared with the motion of the same sender
    format : of the newest packet, None before the first
    state : what the sender's microphone does, as far as the sender has told
    noise_level : of the sender's background noise, -dBFS
    lost_ms : duration of the frames returned as lost; late : packets that arrived after their deadline
    """

    def __init__(self, clock: PlayoutClock | None = None, peer_clock: PeerStreamClock | None = None) -> None:
        self.clock = clock or PlayoutClock()
        self.format: VoiceFormat | None = None
        self.state = VoiceState.OFF
        self.noise_level = MAX_NOISE_LEVEL
        self.lost_ms = 0
        self.late = 0
        self._peer_clock = peer_clock or PeerStreamClock()
        self._formats: dict[int, VoiceFormat] = {}  # by format number
        self._restarts = self.clock.restarts
        self._newest_counter = -1
        self._frames: dict[int, VoiceFrame] = {}  # by stream time, ms
        # Stream times at which talk spurts begin and end, ms, as far as the sender has told.
        self._begins: set[int] = set()
        self._ends: set[int] = set()
        self._stored_until = 0  # end of the newest frame that has arrived, ms
        self._played_until = 0  # end of the newest frame that was returned, ms
        self._playing: VoiceFormat | None = None  # of that frame; None in silence
        self._concealed_ms = 0  # lost without an end, up to there

    def receive_format(self, message: VoiceFormatMessage) -> None:
        """Apply the meaning of a format number."""
        self._formats[message.format_number] = message.format

    def receive_state(self, message: VoiceStateMessage, counter: int) -> None:
        """Apply a state unless something newer has arrived. counter : of its datagram"""
        if counter > self._newest_counter:
            self._newest_counter = counter
            self.state, self.noise_level = message.state, message.noise_level
            self._ends.add(self._stored_until)

    def receive_voice(self, payload: VoicePayload, counter: int, now: float) -> float:
        """Store the frames of a packet. Returns the stream time of its end, seconds.

        Raises ProtocolError if its format is not known or its data does not have the format's size.
        """
        voice_format = self._formats.get(payload.format_number)
        if voice_format is None:
            raise ProtocolError("voice in a format that was not described")
        repeated = 0 if payload.begins else voice_format.repeated
        frames = unpack_frames(payload.data, voice_format, voice_format.frames + repeated)
        start_ms = self._number(payload.number, now) * GRID_MS
        start_s, end_s = start_ms / 1000, start_ms / 1000 + voice_format.packet_s
        self.clock.packet_s = voice_format.coverage_s
        repeated_ms = repeated * voice_format.frame_ms
        self.clock.on_arrival(start_s - repeated_ms / 1000, now, medium=Medium.VOICE)
        self._peer_clock.advance(end_s, now)
        self._forget_an_old_clock()
        if counter > self._newest_counter:
            self._newest_counter = counter
            self.format, self.state = voice_format, VoiceState.TALKING
        if payload.begins:
            self._begins.add(start_ms)
        self.late += start_ms < self._played_until
        self._store(start_ms, voice_format, frames[: voice_format.frames])
        self._store(start_ms - repeated_ms, voice_format, frames[voice_format.frames :])
        return end_s

    def frames_until(self, stream_time: float) -> list[VoiceFrame]:
        """Return the frames that start before `stream_time` and were not returned before, in order of time.

        What is lost between them comes as frames without data; silence does not come at all.
        """
        self._forget_an_old_clock()
        until = stream_time * 1000
        result: list[VoiceFrame] = []
        while (frame := self._next_frame(until)) is not None:
            result.append(frame)
            self.lost_ms += frame.format.frame_ms if frame.data is None else 0
        return result

    def awaits_packet(self, stream_time: float) -> bool:
        """Return whether `frames_until` would begin to conceal what may only be late: nothing newer has arrived."""
        if self._playing is None or self.state is not VoiceState.TALKING or self._concealed_ms:
            return False
        return max(self._played_until, self._stored_until) < stream_time * 1000

    def _next_frame(self, until: float) -> VoiceFrame | None:
        stored = min(self._frames, default=None)
        # A frame may start before the end of what was returned if a gap was no multiple of the frames in it.
        if self._playing is None or (stored is not None and stored <= self._played_until):
            return self._pop_due(stored, until)
        if stored is None:
            if self.state is not VoiceState.TALKING or self._concealed_ms >= MAX_GAP_MS:
                self._playing = None
                return None
        elif self._is_silence(self._played_until, stored):
            return self._pop_due(stored, until)
        if self._played_until >= until:
            return None
        frame = VoiceFrame(self._played_until / 1000, self._playing, None)
        self._concealed_ms += self._playing.frame_ms
        self._played_until += self._playing.frame_ms
        return frame

    def _is_silence(self, begin: int, end: int) -> bool:
        return end in self._begins or begin in self._ends or end - begin > MAX_GAP_MS

    def _pop_due(self, at: int | None, until: float) -> VoiceFrame | None:
        """Return the stored frame at a stream time if it is due."""
        if at is None or at >= until:
            return None
        frame = self._frames.pop(at)
        self._played_until, self._playing = at + frame.format.frame_ms, frame.format
        self._concealed_ms = 0
        self._begins = {time for time in self._begins if time > at}
        self._ends = {time for time in self._ends if time > at}
        return frame

    def _store(self, start_ms: int, voice_format: VoiceFormat, frames: list[bytes]) -> None:
        for position, data in enumerate(frames):
            at = start_ms + position * voice_format.frame_ms
            if at >= self._played_until and (data or at not in self._frames):
                self._frames[at] = VoiceFrame(at / 1000, voice_format, data or None)
                self._stored_until = max(self._stored_until, at + voice_format.frame_ms)
        while len(self._frames) > MAX_FRAMES:
            del self._frames[min(self._frames)]
        for times in (self._begins, self._ends):
            if len(times) > MAX_FRAMES:
                times.remove(min(times))

    def _number(self, low_bits: int, now: float) -> int:
        stream_time = self._peer_clock.time(now)
        if stream_time is None:
            return low_bits
        expected = max(0, round(stream_time * 1000 / GRID_MS))
        return unwrap(low_bits, bits=VOICE_NUMBER_BITS, expected=expected)

    def _forget_an_old_clock(self) -> None:
        if self._restarts != self.clock.restarts:
            self._restarts = self.clock.restarts
            self._frames.clear()
            self._begins.clear()
            self._ends.clear()
            self._stored_until = self._played_until = 0
            self._playing = None
