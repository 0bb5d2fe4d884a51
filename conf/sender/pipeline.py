"""The sending loop: from a motion source to the wire, composed of parts that step."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass

from conf.errors import NetworkError
from conf.protocol.address import Address
from conf.protocol.send_leg import LinkStatus
from conf.protocol.sender_connection import SenderConnection
from conf.protocol.session.events import AddressChanged, Connected, Event, NoAnswer, Refused, SessionEnded, WrongCode
from conf.protocol.session.handshake import Refusal
from conf.sender.face_capture import CapturedMotion, FaceCapture, send_motion
from conf.sender.motion_source import MotionSource
from conf.sender.voice.voice_poller import VoicePoller
from conf.sender.voice.voice_sender import VoiceSender
from conf.transport.exchange import DatagramExchange
from conf.transport.interface import Transport

STATUS_INTERVAL_S = 0.25
POLL_S = 0.1
WRONG_WORDS = "the words are wrong: type the code as the receiver shows it (conf send {nameplate}-WORD-WORD-WORD)"
NOBODY_WAITS = "nobody waits with the number {nameplate}: is the number right, and the relay the same?"
NO_REPLY = "who waits with the number {nameplate} has not answered: try again"
WRONG_CODE = "the code is wrong: type it as the receiver shows it (conf send ... --code CODE)"
NO_ANSWER = "nobody answered: start `conf receive` there, with --listen PORT to be reached from other machines"
REFUSALS = {
    Refusal.LOCKED: "too many wrong codes: the receiver listens again in {wait:.0f} s",
    Refusal.FULL: "the receiver has no room for one more caller: try later",
    Refusal.BUSY: "the receiver is busy: trying again in {wait:.0f} s",
    Refusal.IN_CALL: "the other end is in a call: trying again in {wait:.0f} s",
}


@dataclass(frozen=True)
class SenderStatus:
    """State of the call: counts since the start, rates of the last seconds, UDP/IP headers included.

    voice : what the microphone does: "off", "silent", "talking", "muted", or "no_room" in the rate
    path : how datagrams reach the receiver: "direct", "relay" or "relay over TCP"; "" before there is a connection
    """

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
    voice: str = "off"
    path: str = ""


class SenderLoop:
    """Sends each frame of a source at its time. `run` does it all; `step` fits into another program's loop."""

    def __init__(
        self, source: MotionSource, connection: SenderConnection, socket: Transport, *, voice: VoiceSender | None = None
    ) -> None:
        """voice : the caller's, None to send none"""
        self._connection = connection
        self._socket = socket
        self._capture = FaceCapture(source, connection.outbound.profile.fps)
        self._voice = VoicePoller(voice)
        self._exchange = DatagramExchange(socket, connection)
        self._has_begun = False
        self._receiver: Address | None = None
        self._refusal = ""  # the last event
        self._note = "calling"
        self._on_status: Callable[[SenderStatus], None] | None = None
        self._status_due = 0.0
        self._end = float("inf")

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

        The first frame is read after the handshake, so that no clip starts before somebody can see it.
        Returns the seconds until the next call, which should come sooner if a datagram arrives; None at the end.
        Raises as `run`.
        """
        self._exchange.receive(now)
        if (captured := self._capture.pop()) is not None:
            self._send(captured, now)
        else:
            self._voice.poll(self._capture.source_time(now), self._connection, now)
        self._exchange.send(now)
        while event := self._connection.next_event():
            if isinstance(event, Connected | AddressChanged):
                self._receiver = event.address
            is_awaited = self._socket.others_wait
            text = describe_event(event, nameplate=self._socket.nameplate, is_awaited=is_awaited)
            self._note = text or self._note
            self._refusal = text if isinstance(event, Refused) else ""
        if self._on_status and now >= self._status_due:
            self._status_due = now + STATUS_INTERVAL_S
            self._on_status(self.status(now))
        self._has_begun |= self._connection.status(now).connected
        if now >= self._end:
            if not self._has_begun:
                raise NetworkError(self._unanswered())
            return None
        if not self._has_begun:
            return POLL_S
        self._capture.set_fps(self._connection.outbound.profile.fps)
        wait = self._capture.step(now)
        return None if wait is None else min(wait, POLL_S, self._voice.wait_s(now))

    def _unanswered(self) -> str:
        """Return why there was no call."""
        if self._refusal:
            return self._refusal
        nameplate = self._socket.nameplate
        if not nameplate:
            return NO_ANSWER
        return (NO_REPLY if self._socket.others_wait else NOBODY_WAITS).format(nameplate=nameplate)

    def close(self, now: float) -> None:
        """End the call and notify the receiver, if that is possible."""
        with contextlib.suppress(NetworkError):
            self._socket.send(self._connection.close(now))

    def status(self, now: float) -> SenderStatus:
        """Return the state of the call."""
        traffic, sent = self._connection.traffic, self._connection.outbound.frames_sent
        return SenderStatus(
            frames_captured=self._capture.frames,
            frames_tracked=self._capture.tracked,
            frames_sent=sent,
            tracker_ms_median=self._capture.tracker_ms,
            wire_bytes_per_frame=traffic.total / max(sent, 1),
            wire_kbps=traffic.rates(now)[0] * 8 / 1000,
            face=self._capture.has_face,
            calibrated=self._capture.calibrated,
            link=self._connection.status(now),
            note=self._capture.note or self._exchange.note or self._voice.note or self._note,
            voice=self._connection.voice_state.name.lower(),
            path="" if self._receiver is None else self._socket.path_name(self._receiver),
        )

    def _send(self, captured: CapturedMotion, now: float) -> None:
        """Send a frame, and with it the voice packets that are complete."""
        send_motion(self._connection, captured, now)
        self._voice.poll_now(self._capture.source_time(now), self._connection, now)


def describe_event(event: Event, *, nameplate: str = "", is_awaited: bool = True) -> str:
    """Return what a session event means for the user. Raises NetworkError when the call cannot go on.

    nameplate : of a call over a relay, "" for a direct one; is_awaited : whether somebody waits with it
    """
    match event:
        case WrongCode():
            raise NetworkError(WRONG_WORDS.format(nameplate=nameplate) if nameplate else WRONG_CODE)
        case Refused(refusal=refusal, wait_s=None):
            raise NetworkError(REFUSALS[refusal])
        case Refused(refusal=refusal, wait_s=wait):
            return REFUSALS[refusal].format(wait=wait)
        case Connected():
            return "connected"
        case NoAnswer() if nameplate and not is_awaited:
            return f"{NOBODY_WAITS.format(nameplate=nameplate)} trying on"
        case NoAnswer(seconds=seconds):
            question = "is `conf receive` running there, of the same version?"
            return f"nobody has answered for {seconds:.0f} s: {question} trying on"
        case SessionEnded():
            return "the receiver is gone: calling again"
        case _:
            return ""
