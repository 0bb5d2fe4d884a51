"""The sending loop: from a motion source to the wire.

`SenderLoop._steps` is the way of one frame from top to bottom; each part it calls is a module of its own.
"""

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from conf.errors import AudioError, CameraError, NetworkError
from conf.protocol.messages import MotionFrame
from conf.protocol.send_leg import LinkStatus
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.events import Connected, Event, NoAnswer, Refused, SessionEnded, WrongCode
from conf.protocol.session.handshake import Refusal
from conf.protocol.voice.formats import VoiceState
from conf.sender.frame_pacer import FramePacer
from conf.sender.motion_source import MotionSource
from conf.sender.voice.voice_sender import VoiceSender
from conf.transport.fault_tolerance import CAMERA_LIMIT_S, NETWORK_LIMIT_S, FaultTolerance
from conf.transport.udp import UdpSocket

STATUS_INTERVAL_S = 0.25
POLL_S = 0.1
VOICE_POLL_S = 0.01  # a block of the microphone's processing; the frames that wait go with a complete packet
RETRY_S = 0.25  # between two attempts to read a camera that fails
WRONG_CODE = "the code is wrong: type it as the receiver shows it (conf send ... --code CODE)"
NO_ANSWER = "nobody answered: start `conf receive` there, with --listen PORT to be reached from other machines"
REFUSALS = {
    Refusal.LOCKED: "too many wrong codes: the receiver listens again in {wait:.0f} s",
    Refusal.FULL: "the receiver has no room for one more caller: try later",
    Refusal.BUSY: "the receiver is busy: trying again in {wait:.0f} s",
}


@dataclass(frozen=True)
class SenderStatus:
    """State of the call: counts since the start, rates of the last seconds, UDP/IP headers included."""

    frames_captured: int
    frames_tracked: int
    frames_sent: int
    tracker_ms_median: float
    wire_bytes_per_frame: float
    wire_kbps: float
    face: bool
    calibrated: bool
    link: LinkStatus
    note: str


class SenderLoop:
    """Sends each frame of a source at its time. `run` does it all; `step` fits into another program's loop."""

    def __init__(
        self, source: MotionSource, connection: SenderConnection, socket: UdpSocket, *, voice: VoiceSender | None = None
    ) -> None:
        """voice : the caller's, None to send none"""
        self._source = source
        self._voice = voice
        self._voice_note = ""
        self._voice_polled_at = float("-inf")
        self._connection = connection
        self._socket = socket
        self._pacer = FramePacer(connection.outbound.profile.fps)
        self._captured = self._tracked = 0
        self._face = False
        self._note = "calling"
        self._network = FaultTolerance(NETWORK_LIMIT_S)
        self._receiving = FaultTolerance(NETWORK_LIMIT_S)
        self._camera = FaultTolerance(CAMERA_LIMIT_S)
        self._on_status: Callable[[SenderStatus], None] | None = None
        self._status_due = 0.0
        self._now = 0.0
        self._end = float("inf")
        self._running = self._steps()

    def run(
        self,
        *,
        seconds: float | None = None,
        on_status: Callable[[SenderStatus], None] | None = None,
        should_continue: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> SenderStatus:
        """Send until the source ends, for `seconds`, or until `should_continue` returns False.

        Failures of the network are survived for 10 s, of the camera for 5 s, once each has worked.
        Raises CameraError when the camera stops for good, NetworkError when nothing can be sent, nobody answers or the
        receiver refuses.
        """
        self._on_status = on_status
        if seconds is not None:
            self._end = clock() + seconds
        try:
            while should_continue() and (wait := self.step(clock())) is not None:
                if wait:
                    self._socket.wait(wait)
        finally:
            self.close(clock())
        return self.status(clock())

    def step(self, now: float) -> float | None:
        """Do what is due at `now`, seconds on a monotonic clock, which reading a camera and tracking a face may delay.

        Returns the seconds until the next call, which should come sooner if a datagram arrives; None at the end.
        Raises as `run`.
        """
        self._now = now
        return next(self._running, None)

    def close(self, now: float) -> None:
        """End the call and notify the receiver, if that is possible."""
        with contextlib.suppress(NetworkError):
            self._socket.send(self._connection.close(now))

    def status(self, now: float) -> SenderStatus:
        """Return the state of the call."""
        traffic, sent = self._connection.traffic, self._connection.outbound.frames_sent
        return SenderStatus(
            frames_captured=self._captured,
            frames_tracked=self._tracked,
            frames_sent=sent,
            tracker_ms_median=self._source.tracker_ms,
            wire_bytes_per_frame=traffic.total / max(sent, 1),
            wire_kbps=traffic.rates(now)[0] * 8 / 1000,
            face=self._face,
            calibrated=self._source.calibrated,
            link=self._connection.status(now),
            note=self._camera.note or self._network.note or self._receiving.note or self._voice_note or self._note,
        )

    def _steps(self) -> Iterator[float]:
        """Yield the seconds until the next step. A step starts wherever `self._now` must be up to date.

        The first frame is read after the handshake, so that no clip starts before somebody can see it.
        """
        while not self._connection.status(self._now).connected:
            if self._now >= self._end:
                raise NetworkError(NO_ANSWER)
            yield from self._exchange_until(self._now + POLL_S)
        while self._now < self._end:
            try:
                timestamp = self._source.next_frame()
            except CameraError as error:
                self._camera.on_failure(error, self._now)
                yield from self._exchange_until(self._now + RETRY_S)
                continue
            self._camera.on_success()
            if timestamp is None:
                return
            yield 0.0
            if self._now >= self._end:
                return
            self._captured += 1
            self._pacer.fps = self._connection.outbound.profile.fps
            delay = self._pacer.delay_for(timestamp, self._now)
            if delay is None:
                continue
            yield from self._exchange_until(self._now + delay)
            motion = self._source.motion()
            yield 0.0
            self._send(timestamp, motion)
            self._source.after_send(self._now)

    def _exchange_until(self, until: float) -> Iterator[float]:
        """Receive and send datagrams until a time, at least once."""
        while True:
            self._receive()
            if self._now - self._voice_polled_at >= VOICE_POLL_S:
                self._poll_voice()
            self._transmit()
            while event := self._connection.next_event():
                self._note = describe_event(event)
            if self._on_status and self._now >= self._status_due:
                self._status_due = self._now + STATUS_INTERVAL_S
                self._on_status(self.status(self._now))
            if self._now >= until:
                return
            yield min(until - self._now, POLL_S)

    def _send(self, timestamp: float, motion: MotionFrame | None) -> None:
        self._face = motion is not None
        if motion is None:
            self._connection.send_no_face(timestamp, self._now)
        else:
            self._tracked += 1
            outbound = self._connection.outbound
            outbound.parameters = replace(outbound.parameters, fapu=self._source.fapu_lengths)
            self._connection.send_frame(motion, self._now)
        self._poll_voice()
        self._transmit()

    def _poll_voice(self) -> None:
        """Send the voice packets that are complete by now. The frames that wait leave in their datagrams."""
        source_time = self._pacer.source_time(self._now)
        if self._voice is not None and source_time is not None:
            try:
                self._voice.poll(source_time, self._connection, self._now)
            except AudioError as error:
                self._voice.close()
                self._voice, self._voice_note = None, str(error)
                self._connection.set_voice_state(VoiceState.OFF, self._now)
        self._voice_polled_at = self._now

    def _receive(self) -> None:
        """Process the datagrams received. Raises NetworkError if receiving has failed for too long."""
        try:
            datagrams = self._socket.receive()
        except NetworkError as error:
            self._receiving.on_failure(error, self._now)
            return
        self._receiving.on_success()
        for datagram in datagrams:
            self._connection.receive_datagram(datagram.data, datagram.address, self._now)

    def _transmit(self) -> None:
        """Send what is due. Raises NetworkError if that has failed for too long."""
        datagrams = self._connection.datagrams_to_send(self._now)
        if not datagrams:
            return
        try:
            self._socket.send(datagrams)
        except NetworkError as error:
            self._network.on_failure(error, self._now)
        else:
            self._network.on_success()


def describe_event(event: Event) -> str:
    """Return what a session event means for the user. Raises NetworkError when the call cannot go on."""
    match event:
        case WrongCode():
            raise NetworkError(WRONG_CODE)
        case Refused(refusal=refusal, wait_s=None):
            raise NetworkError(REFUSALS[refusal])
        case Refused(refusal=refusal, wait_s=float(wait)):
            return REFUSALS[refusal].format(wait=wait)
        case Connected():
            return "connected"
        case NoAnswer(seconds=seconds):
            question = "is `conf receive` running there, of the same version?"
            return f"nobody has answered for {seconds:.0f} s: {question} trying on"
        case SessionEnded():
            return "the receiver is gone: calling again"
        case _:
            return ""
