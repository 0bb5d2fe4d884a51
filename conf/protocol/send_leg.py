"""The sending half of a call: motion, voice and portrait out, reports in, as bodies. No I/O, no clock, no sealing.

Strategy. While somebody talks, motion waits for the voice packet of its time, so that one datagram carries both. In
silence and without voice it leaves as soon as its datagram is full. CallLeg puts bodies that leave together into one
datagram.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from conf.protocol import messages
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.feedback import Report, RoundTripEstimator
from conf.protocol.motion.outbound import OutboundMotion
from conf.protocol.outgoing import OutgoingBody
from conf.protocol.participant.outbound import OutboundParticipant
from conf.protocol.participant.state import CameraState
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import DATAGRAM_OVERHEAD, SEAL_BYTES, RateOptions, SendBudget
from conf.protocol.reception_statistics import REPORT_INTERVAL_S
from conf.protocol.statistics import HEADER_BYTES
from conf.protocol.stream_clocks import StreamClock
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.voice.outbound import OutboundVoice
from conf.protocol.wire import MAX_INNER_BODY, MOTION_BIT, VOICE_BIT, encode_body

PIGGYBACK_BYTES = 2  # overhead of a chunk in a datagram with motion: its kind and that of the composite
# A chunk in a datagram with motion needs no headers; without motion for so long it is sent alone. During startup a
# frame's time must do: a still face sends no motion, and its portrait would have to wait.
MAX_PIGGYBACK_WAIT_S = 0.2
STARTUP_PIGGYBACK_WAIT_S = 0.06
ROUND_TRIP_INTERVAL_S = 10.0
VOICE_LATENESS_S = 0.06  # of a voice packet, beyond half of its duration, for which motion still waits
VOICE_HEADERS = HEADER_BYTES + SEAL_BYTES
PACKETS_PER_REPORT = 4
ACTIVE_S = 1.5  # after the last body no other is to be expected: even a still face sends one each second
RIDE_WAIT_S = 0.25  # for which a report waits for a datagram


@dataclass(frozen=True)
class LinkStatus:
    """The state of the link as far as reports tell; None where none has arrived yet."""

    connected: bool
    stopped: bool
    profile: str
    frames_per_datagram: int
    round_trip_ms: float | None
    loss_percent: float | None
    jitter_ms: float | None


class SendLeg:
    """Turn one person's motion, voice and portrait into message bodies within the send budget.

    motion, voice : the outgoing streams, with one clock; participant : name and camera; budget : what may be sent
    """

    def __init__(
        self,
        parameters: messages.StreamParameters,
        now: float,
        *,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
        name: str = "",
        head: int = 0,
    ) -> None:
        """portrait : the objects of the sender's portrait, None to send none; name, head : of the participant"""
        clock = StreamClock()
        self.motion = OutboundMotion(parameters, clock=clock)
        self.voice = OutboundVoice(clock)
        self.participant = OutboundParticipant(name, head=head)
        self.budget = SendBudget(rate or RateOptions(), now)
        self._portrait = portrait
        self._connected = self._was_portrait_allowed = False
        self._timestamp = 0.0
        self._piggybacked_at = float("-inf")
        self._sent_at = float("-inf")  # the last body
        self._voice_until = float("-inf")  # the next voice packet is due by then, if somebody talks
        self._sent_round_trip_ms = 0.0
        self._round_trip_due = now
        self._apply_level()

    @property
    def voice_format(self) -> VoiceFormat | None:
        """The format to encode voice in now. None: voice is off, the limit has no room, or there is no session."""
        return self.budget.voice_format if self._connected else None

    def start(self, now: float) -> None:
        """Begin to send in a new session, whose receiver knows nothing."""
        self._connected = True
        self.budget.restart(now)
        self.motion.restart()
        self.voice.restart()
        self.participant.restart(now)
        if self._portrait:
            self._portrait.restart()

    def stop(self) -> None:
        """Stop sending: the session has ended."""
        self._connected = False

    def send_frame(self, frame: messages.MotionFrame, now: float) -> None:
        """Send one frame; it is dropped while there is no session or the budget is stopped."""
        self._timestamp = frame.timestamp
        self.participant.set_camera(CameraState.ON, now)
        if self._may_send(now):
            self.motion.wait_for_flush(self._voice_flows(now))
            self.motion.send_frame(frame, now)

    def send_no_face(self, timestamp: float, now: float) -> None:
        """Report that there is no face at `timestamp`."""
        self._timestamp = timestamp
        self.participant.set_camera(CameraState.ON, now)
        if self._may_send(now):
            self.motion.send_no_face(timestamp, now)

    def send_camera_off(self, now: float) -> None:
        """Announce that the camera is off. Nothing of the face is sent until `send_frame` or `send_no_face`."""
        self.participant.set_camera(CameraState.OFF, now)
        self.motion.discard()

    def set_portrait_allowed(self, is_allowed: bool, /, now: float) -> None:
        """Announce whether the images sent of the person may be shown. It costs nothing before they first were."""
        self._was_portrait_allowed |= is_allowed
        self.participant.set_portrait_withdrawn(self._was_portrait_allowed and not is_allowed, now)

    def send_voice(self, packet: VoicePacket, now: float) -> None:
        """Send encoded voice, which means that somebody talks; dropped as a frame is.

        Raises ValueError if its frames are not as many and as long as its format says.
        """
        if self._may_send(now):
            self.budget.on_voice(packet.format, self.voice.send(packet))
            self._voice_until = now + 1.5 * packet.format.packet_s + VOICE_LATENESS_S

    def set_voice_state(self, state: VoiceState, now: float, *, noise_level: int = 127) -> None:
        """Announce what the microphone does. noise_level : of the background noise, -dBFS, 0 to 127"""
        self.voice.set_state(state, noise_level, now)
        if state is not VoiceState.TALKING:
            self._voice_until = now

    def bodies_to_send(self, now: float, *, reserved: int = 0) -> list[OutgoingBody]:
        """Return the bodies to send now, those that need no datagram of their own last.

        reserved : bytes that the datagram must leave for others
        """
        if self._connected and self.budget.consume_probe(now):
            is_off = self.participant.camera is CameraState.OFF
            return [self.participant.body(now) if is_off else self.motion.probe(self._timestamp)]
        if self.voice.has_packet:
            bodies, room = self._voice_and_motion(now, reserved)
        elif self._voice_flows(now):
            return []
        else:
            self.motion.wait_for_flush(False)
            bodies, room = self.motion.drain(), None
        bodies += self._round_trip_message(now)
        bodies += self._chunk(bodies, now, room)
        if self._may_send(now):
            bodies += self.voice.state_bodies(now, alone=not bodies)
            bodies += self._announcement(bodies, now)
        if bodies:
            self._sent_at = now
        return bodies

    def room(self, now: float) -> float:
        """Return the bytes that may go with the voice packets that wait, if any; otherwise no limit is known."""
        if not self.voice.has_packet:
            return float("inf")
        return self.budget.room_beside_voice(VOICE_HEADERS + self.voice.waiting_bytes, now)

    def report_interval_s(self, now: float) -> float:
        """Return the seconds from one report to the next: in long voice packets reports would crowd out motion."""
        voice_format = self.voice_format
        if voice_format is None or not self._voice_flows(now):
            return REPORT_INTERVAL_S
        return max(REPORT_INTERVAL_S, PACKETS_PER_REPORT * voice_format.packet_s)

    def ride_wait(self, now: float) -> float:
        """Return the seconds that a report may wait for the next datagram, 0 if none is to be expected."""
        if self._voice_flows(now):
            return max(RIDE_WAIT_S, self._voice_until - now)
        is_active = now < self._sent_at + ACTIVE_S
        return max(RIDE_WAIT_S, 1.25 * self.motion.datagram_interval_s) if is_active else 0.0

    def closing_bodies(self) -> list[OutgoingBody]:
        """Return the bodies that end the call, each for a datagram of its own: two, as one may be lost."""
        return [OutgoingBody(encode_body(messages.Bye()))] * 2

    def on_sent(self, counter: int, outgoing: OutgoingBody, now: float) -> None:
        """Record the counter of the datagram in which a body was sent."""
        self.motion.on_sent(counter, outgoing)
        self.voice.on_sent(counter, outgoing)
        self.participant.on_sent(counter, outgoing)
        self.budget.on_sent(counter, VOICE_HEADERS + len(outgoing.body), now)

    def on_path_changed(self) -> None:
        """Forget the round trip time: the receiver is at another address. Source: RFC 9000, 9.4."""
        self.budget.round_trip = RoundTripEstimator()

    def receive_report(self, feedback: messages.Feedback, now: float) -> None:
        """Apply a report from the receiver."""
        report: Report = feedback.report
        self.budget.on_report(report, now)
        if feedback.refresh:
            self.motion.drop_references()
        acknowledged = report.acknowledged()
        self.motion.on_acknowledged(acknowledged)
        self.voice.on_acknowledged(acknowledged)
        self.participant.on_acknowledged(acknowledged)
        self._apply_level()

    def receive_portrait_ack(self, ack: messages.PortraitAck) -> None:
        """Apply an acknowledgement of portrait chunks. Raises ProtocolError if it is malformed."""
        if self._portrait and self._portrait.receive_ack(ack.data):
            self.budget.chunks.restart()

    def status(self, now: float) -> LinkStatus:
        """Return the state of the link."""
        round_trip_s, loss, level = self.budget.round_trip.smoothed_s, self.budget.loss, self.budget.level
        return LinkStatus(
            connected=self._connected,
            stopped=self._connected and self.budget.is_stopped(now),
            profile=level.profile,
            frames_per_datagram=self.motion.profile.frames_per_datagram * level.bundling,
            round_trip_ms=None if round_trip_s is None else round_trip_s * 1000,
            loss_percent=loss.fraction * 100 if loss.expected else None,
            jitter_ms=self.budget.jitter_ms,
        )

    def _may_send(self, now: float) -> bool:
        return self._connected and not self.budget.is_stopped(now) and not self.budget.is_paused(now)

    def _voice_flows(self, now: float) -> bool:
        """Return whether a voice packet is to be expected, for which motion waits."""
        return self.voice.has_packet or now < self._voice_until

    def _voice_and_motion(self, now: float, reserved: int) -> tuple[list[OutgoingBody], float]:
        """Return the voice packets that wait and the motion that has room beside them, and the bytes still left.

        An announcement goes first: motion waits until there is room for it.
        """
        voice = self.voice.drain()
        room = self.budget.room_beside_voice(VOICE_HEADERS + sum(len(body.body) + 1 for body in voice) + reserved, now)
        if self.participant.is_due(now) and self._may_send(now):
            if room < self.participant.max_bytes:
                return voice, 0.0
            voice.append(self.participant.body(now))
            room -= self.participant.max_bytes
        waiting = sum(len(body.body) + 1 for body in self.motion.waiting)
        self.motion.flush(room - waiting - 1)
        bodies = []
        for body in self.motion.drain():
            if len(body.body) + 1 <= room:
                room -= len(body.body) + 1
                bodies.append(body)
        return bodies + voice, room

    def _apply_level(self) -> None:
        level = self.budget.level
        self.motion.set_profile(PROFILES[level.profile], bundling=level.bundling)

    def _round_trip_message(self, now: float) -> list[OutgoingBody]:
        """Return a message with the round trip time, seldom and only if it has changed: it costs a datagram."""
        round_trip_s = self.budget.round_trip.smoothed_s
        if round_trip_s is None or now < self._round_trip_due or not self._may_send(now):
            return []
        milliseconds = round_trip_s * 1000
        if abs(milliseconds - self._sent_round_trip_ms) < max(0.25 * self._sent_round_trip_ms, 5.0):
            return []
        self._round_trip_due, self._sent_round_trip_ms = now + ROUND_TRIP_INTERVAL_S, milliseconds
        return [OutgoingBody(encode_body(messages.RoundTripMessage(round(milliseconds))))]

    def _announcement(self, bodies: Sequence[OutgoingBody], now: float) -> list[OutgoingBody]:
        """Return the announcement of the participant if it is due; voice packets have it with them already."""
        if any(body.kind == VOICE_BIT for body in bodies):
            return []
        is_due = self.participant.is_due(now) if bodies else self.participant.is_due_alone(now, self._sent_at)
        return [self.participant.body(now)] if is_due else []

    def _chunk(self, bodies: Sequence[OutgoingBody], now: float, room: float | None) -> list[OutgoingBody]:
        """Return at most one portrait chunk, in the datagram of the bodies where they are motion or voice."""
        if self._portrait is None or not self._connected or self.participant.camera is CameraState.OFF:
            return []
        if not self.budget.allows_chunk(now, room):
            return []
        rides = any(body.kind in (MOTION_BIT, VOICE_BIT) for body in bodies)
        rides = rides and max(len(body.body) for body in bodies) <= MAX_INNER_BODY
        max_wait_s = STARTUP_PIGGYBACK_WAIT_S if self.budget.chunks.in_startup else MAX_PIGGYBACK_WAIT_S
        if not rides and now < self._piggybacked_at + max_wait_s:
            return []
        overhead = PIGGYBACK_BYTES if rides else DATAGRAM_OVERHEAD
        data = self._portrait.next_chunk(now, self.budget.chunks, overhead=overhead)
        if rides or data is not None:
            self._piggybacked_at = now
        return [] if data is None else [OutgoingBody(encode_body(messages.PortraitChunk(data)))]
