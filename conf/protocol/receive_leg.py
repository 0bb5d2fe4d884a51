"""The receiving half of a call: message bodies in; motion, voice and portrait objects out. No I/O, no clock."""

from collections import deque

from conf.protocol import messages
from conf.protocol.codec.reference_frames import MissingReferenceError
from conf.protocol.motion.inbound import InboundMotion
from conf.protocol.participant.state import CameraState
from conf.protocol.portrait.object_receiver import ObjectReceiver
from conf.protocol.reception_statistics import ReceptionStatistics
from conf.protocol.statistics import MediaTraffic, RateWindow, TrafficSnapshot, count_media, raw_frame_bytes
from conf.protocol.stream_clocks import PeerStreamClock, PlayoutClock
from conf.protocol.voice.inbound import InboundVoice

SILENCE_S = 3.0
MAX_OBJECTS = 64  # received objects that wait to be used


class ReceiveLeg:
    """Receive what one sender sends. Knows nothing of sealing.

    motion, voice : the incoming streams; clock : when what they hold is due
    received_objects : complete objects of the sender's portrait, oldest first, for the user to remove
    traffic : bytes received, headers included; media : the same by what they carry
    last_received : when the newest datagram came, None before the first
    rejected : malformed bodies; missed_references : frames whose reference had not arrived
    refresh_needed : whether the next report must say that a reference is missing
    name : of the participant, "" if unknown; head : number of the head that it has chosen, 0 for none
    is_portrait_withdrawn : whether the images received of the person are no longer to be shown
    round_trip_ms : as the sender measured it, None before it has told
    reception : statistics of the datagrams received
    """

    def __init__(self, receiver_id: int = 0) -> None:
        """receiver_id : 16 bits by which the sender recognises the receiver of its portrait"""
        self.clock = PlayoutClock()
        peer_clock = PeerStreamClock()
        self.motion = InboundMotion(self.clock, peer_clock)
        self.voice = InboundVoice(self.clock, peer_clock)
        self.received_objects: deque[bytes] = deque(maxlen=MAX_OBJECTS)
        self.traffic = RateWindow()
        self.media = MediaTraffic()
        self.rejected = 0
        self.missed_references = 0
        self.refresh_needed = False
        self.name = ""
        self.is_portrait_withdrawn = False
        self.head = 0
        self.round_trip_ms: float | None = None
        self.reception = ReceptionStatistics()
        self._object_receiver = ObjectReceiver(receiver_id)
        self.last_received: float | None = None
        self._camera = CameraState.ON
        self._camera_counter = -1  # of the datagram that told
        self._participant_counter = -1

    @property
    def camera(self) -> CameraState:
        """What the sender's camera shows, as far as it has told."""
        has_no_face = self._camera is CameraState.ON and self.motion.presence is messages.Presence.NO_FACE
        return CameraState.NO_FACE if has_no_face else self._camera

    @property
    def portrait_percent(self) -> int | None:
        """How much of the sender's photo has arrived, None if none has been announced or it was withdrawn."""
        return None if self.is_portrait_withdrawn else self._object_receiver.photo_percent

    def on_datagram(self, data: bytes, wire_bytes: int, now: float) -> None:
        """Count an authenticated datagram. data : its encoded body; wire_bytes : its size, headers included"""
        self.traffic.add(wire_bytes, now)
        self.media.add(count_media(data, wire_bytes), now)
        self.last_received = now

    def is_silent(self, now: float) -> bool:
        """Return whether nothing has been received for a while, or ever."""
        return self.last_received is None or now - self.last_received > SILENCE_S

    def next_portrait_ack(self, now: float) -> bytes | None:
        """Return the data of a portrait acknowledgement when one is due."""
        return self._object_receiver.next_ack(now)

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the traffic figures."""
        parameters, frames = self.motion.parameters, self.motion.frames
        raw = raw_frame_bytes(parameters.width, parameters.height) if parameters else 0
        received = max(frames.count, 1)
        return TrafficSnapshot(
            frames_received=frames.count,
            frames_lost=round(self.reception.lost * received / max(self.motion.datagrams, 1)),
            frames_late=self.motion.buffer.late,
            datagrams=self.traffic.count,
            rejected=self.rejected,
            fps=frames.rates(now)[1],
            wire_bytes_per_frame=self.traffic.total / received,
            wire_kbps=self.traffic.rates(now)[0] * 8 / 1000,
            raw_bytes_per_frame=raw,
            raw_kbps=raw * (parameters.fps if parameters else 0.0) * 8 / 1000,
            ratio=raw * frames.count / self.traffic.total if self.traffic.total else 0.0,
            jitter_ms=self.reception.jitter.seconds * 1000,
            playout_delay_ms=self.clock.delay_s * 1000,
            media_bytes=self.media.total,
            media_bytes_per_second=self.media.rates(now),
        )

    def receive(self, body: messages.SingleBody, counter: int, now: float) -> float | None:
        """Apply one body; those for a sending half are ignored.

        counter : of its datagram
        Returns the stream time of the newest content, seconds, None without any.
        Raises ProtocolError, and its child MissingReferenceError if a reference frame has not arrived.
        """
        match body:
            case messages.StreamParameters():
                self.motion.receive_parameters(body, now)
            case messages.KeepAlive():
                self._set_camera(CameraState.ON, counter)
                self.motion.receive_keep_alive(body, now)
            case messages.MotionPayload():
                received_until = self._receive_motion(body, now)
                self._set_camera(CameraState.ON, counter)
                return received_until
            case messages.FurrowMessage():
                self.motion.receive_furrows(body, counter)
            case messages.ParticipantMessage():
                self._set_camera(body.camera, counter)
                if counter > self._participant_counter:
                    self._participant_counter = counter
                    self.name, self.is_portrait_withdrawn = body.name, body.is_portrait_withdrawn
                    self.head = body.head
            case messages.VoiceFormatMessage():
                self.voice.receive_format(body)
            case messages.VoiceStateMessage():
                self.voice.receive_state(body, counter)
            case messages.VoicePayload():
                return self.voice.receive_voice(body, counter, now)
            case messages.RoundTripMessage(milliseconds=milliseconds):
                self.round_trip_ms = float(milliseconds)
            case messages.PortraitChunk(data=data):
                self._receive_chunk(data)
        return None

    def _set_camera(self, camera: CameraState, counter: int) -> None:
        """Apply a state of the camera unless a newer datagram has told another."""
        if counter > self._camera_counter:
            self._camera, self._camera_counter = camera, counter

    def _receive_motion(self, body: messages.MotionPayload, now: float) -> float:
        try:
            return self.motion.receive_motion(body, now)
        except MissingReferenceError:
            self.refresh_needed = True
            self.missed_references += 1
            raise

    def _receive_chunk(self, data: bytes) -> None:
        if complete := self._object_receiver.receive_chunk(data):
            self.received_objects.append(complete)
