"""The sending loop: motion from a face or a recording, to the wire.

The way of one frame is read here from top to bottom; every step it calls is a module of its own.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from conf.errors import NetworkError
from conf.protocol.sender_connection import LinkStatus, SenderConnection
from conf.protocol.session.events import Connected, Event, NoAnswer, Refused, SessionEnded, WrongCode
from conf.protocol.session.handshake import Refusal
from conf.sender.frame_pacer import FramePacer
from conf.sender.motion_source import MotionSource
from conf.transport.udp import UdpSocket

STATUS_EVERY_S = 0.25
POLL_S = 0.1
WRONG_CODE = "the code is wrong: type it as the receiver shows it (conf send ... --code CODE)"
NO_ANSWER = "nobody answered: start `conf receive` there, with --listen 0.0.0.0:PORT to be reached from other machines"
REFUSALS = {
    Refusal.LOCKED: "too many wrong codes: the receiver listens again in {wait:.0f} s",
    Refusal.FULL: "the receiver has no room for one more caller: try later",
    Refusal.BUSY: "the receiver is busy: trying again in {wait:.0f} s",
}


@dataclass(frozen=True)
class SenderStatus:
    """How the sending goes: counts since the start, rates of the last seconds, UDP/IP headers counted."""

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
    """Send the motion of a performance, each moment at its time."""

    def __init__(self, performance: MotionSource, caller: SenderConnection, socket: UdpSocket) -> None:
        self._performance = performance
        self._caller = caller
        self._link = socket
        self._pace = FramePacer(caller.outbound.profile.fps)
        self._captured = self._tracked = 0
        self._face = False
        self._note = "calling"
        self._on_status: Callable[[SenderStatus], None] | None = None
        self._status_due = 0.0

    def run(
        self, *, seconds: float | None = None, on_status: Callable[[SenderStatus], None] | None = None
    ) -> SenderStatus:
        """Send until the performance ends, or for `seconds`.

        Raises CameraError when the camera stops, NetworkError when nobody answers or the receiver refuses for good.
        """
        self._on_status = on_status
        end = time.monotonic() + seconds if seconds is not None else float("inf")
        try:
            if not self._connect(end):
                raise NetworkError(NO_ANSWER)
            while (timestamp := self._performance.next_frame()) is not None and (now := time.monotonic()) < end:
                self._captured += 1
                self._pace.fps = self._caller.outbound.profile.fps
                wait = self._pace.delay_for(timestamp, now)
                if wait is not None:
                    self._exchange_until(now + wait)
                    self._send(timestamp)
                    self._performance.after_send()
        finally:
            self._link.send(self._caller.close(time.monotonic()))
        return self.status()

    def status(self) -> SenderStatus:
        """Return how it goes now."""
        now = time.monotonic()
        traffic, sent = self._caller.traffic, self._caller.outbound.frames_sent
        return SenderStatus(
            frames_captured=self._captured,
            frames_tracked=self._tracked,
            frames_sent=sent,
            tracker_ms_median=self._performance.tracker_ms,
            wire_bytes_per_frame=traffic.total / max(sent, 1),
            wire_kbps=traffic.rates(now)[0] * 8 / 1000,
            face=self._face,
            calibrated=self._performance.calibrated,
            link=self._caller.status(now),
            note=self._note,
        )

    def _connect(self, end: float) -> bool:
        """Shake hands before the first frame is read, so that no clip begins unseen. Returns whether it was done."""
        while not self._caller.status(time.monotonic()).connected and time.monotonic() < end:
            self._exchange_until(time.monotonic() + POLL_S)
        return self._caller.status(time.monotonic()).connected

    def _exchange_until(self, until: float) -> None:
        """Take and send datagrams as they come until a moment; at least once."""
        while True:
            now = time.monotonic()
            for data, address, _ in self._link.receive():
                self._caller.receive_datagram(data, address, now)
            self._link.send(self._caller.datagrams_to_send(now))
            while event := self._caller.next_event():
                self._note = describe_event(event)
            self._report_status(now)
            if now >= until:
                return
            self._link.wait(min(until - now, POLL_S))

    def _send(self, timestamp: float) -> None:
        motion = self._performance.motion()
        now = time.monotonic()
        self._face = motion is not None
        if motion is None:
            self._caller.send_no_face(timestamp, now)
        else:
            self._tracked += 1
            outbound = self._caller.outbound
            outbound.parameters = replace(outbound.parameters, fapu=self._performance.fapu_lengths)
            self._caller.send_frame(motion, now)
        self._link.send(self._caller.datagrams_to_send(now))

    def _report_status(self, now: float) -> None:
        if self._on_status and now >= self._status_due:
            self._status_due = now + STATUS_EVERY_S
            self._on_status(self.status())


def describe_event(event: Event) -> str:
    """Return what an event of the session means to the user. Raises NetworkError when the call cannot go on."""
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
            there = "is `conf receive` running there, of the same version?"
            return f"nobody has answered for {seconds:.0f} s: {there} trying on"
        case SessionEnded():
            return "the receiver is gone: calling again"
        case _:
            return ""
