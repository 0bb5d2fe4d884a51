"""The receiving loop: datagrams from the network, pictures to a window.

The way of one frame is read here from top to bottom; every step it calls is a module of its own.
"""

import time
from collections import deque
from collections.abc import Callable

from conf.face.head import FaceModel
from conf.protocol.inbound import Inbound
from conf.protocol.messages import MotionFrame, Presence
from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.meter import MeterReading, draw_meter
from conf.receiver.notices import draw_help, draw_notice
from conf.receiver.overlay import Overlay
from conf.receiver.stage import Stage, Window
from conf.receiver.udp import ReceiverSocket
from conf.receiver.viewer import Viewer

HISTORY_EVERY_S = 0.5
HISTORY_LENGTH = 120


class ReceivingLoop:
    """Show what comes over a link until the window is closed."""

    def __init__(self, window: Window, face: FaceModel, inbound: Inbound, link: ReceiverSocket) -> None:
        self._window = window
        self._stage = Stage(window, face)
        self._overlay = Overlay(window.ctx)
        self._viewer = Viewer(window)
        self._inbound = inbound
        self._link = link
        self._shown: MotionFrame | None = None
        self._drawn: deque[float] = deque(maxlen=30)
        self._history: deque[float] = deque(maxlen=HISTORY_LENGTH)
        self._history_due = 0.0

    def run(
        self,
        *,
        fps: float,
        seconds: float | None = None,
        keep_going: Callable[[], bool] = lambda: True,
        on_picture: Callable[[Window, float], None] | None = None,
    ) -> TrafficSnapshot:
        """Draw until the window closes, `seconds` have passed or `keep_going` says no.

        fps : pictures a second at the most; a window on a display also waits for the display
        on_picture : called with each picture in the window's framebuffer
        Returns the traffic's figures.
        """
        began = time.monotonic()
        due = began
        try:
            while not self._over(began, seconds) and keep_going():
                self._draw(time.monotonic(), on_picture)
                due = max(due + 1 / fps, time.monotonic() - 1 / fps)
                self._serve_until(due)
            return self._inbound.snapshot(time.monotonic())
        finally:
            self._viewer.close()
            self._overlay.release()
            self._stage.release()

    def _over(self, began: float, seconds: float | None) -> bool:
        late = seconds is not None and time.monotonic() - began >= seconds
        return late or self._viewer.wants_to_go or self._window.should_close

    def _serve_until(self, until: float) -> None:
        """Take datagrams as they come, so that each gets its true time of arrival, until the next picture is due."""
        while True:
            for data, _ in self._link.receive():
                self._inbound.receive_datagram(data, time.monotonic())
            left = until - time.monotonic()
            if left <= 0:
                return
            self._link.wait(left)

    def _draw(self, now: float, on_picture: Callable[[Window, float], None] | None) -> None:
        self._viewer.take_events(now)
        playout = self._inbound.play(now)
        if playout and not self._viewer.paused:
            self._shown = playout.frame
        self._window.begin()
        self._stage.draw({0: self._shown} if self._shown else {}, self._viewer.view, now)
        self._draw_panels(now)
        self._viewer.picture_drawn(now)
        if on_picture:
            on_picture(self._window, now)
        self._window.end()
        self._drawn.append(now)

    def _draw_panels(self, now: float) -> None:
        if now >= self._history_due:
            self._history_due = now + HISTORY_EVERY_S
            self._history.append(self._inbound.traffic.rates(now)[0] * 8 / 1000)
        with self._overlay.frame(self._window.framebuffer, self._window.size, self._window.pixel_ratio):
            if self._viewer.view.meter:
                draw_meter(self._overlay, self._reading(now))
            if self._viewer.view.help:
                draw_help(self._overlay)
            if notice := self._viewer.notice(now):
                draw_notice(self._overlay, notice)

    def _reading(self, now: float) -> MeterReading:
        snapshot = self._inbound.snapshot(now)
        parameters = self._inbound.parameters
        span = self._drawn[-1] - self._drawn[0] if len(self._drawn) > 1 else 0.0
        return MeterReading(
            state=self._state(now),
            fps=(len(self._drawn) - 1) / span if span else 0.0,
            bytes_per_frame=snapshot.wire_bytes_per_frame,
            wire_kbps=snapshot.wire_kbps,
            raw_bytes_per_frame=snapshot.raw_bytes_per_frame,
            raw_kbps=snapshot.raw_kbps,
            ratio=snapshot.ratio,
            saved_percent=100 * (1 - 1 / snapshot.ratio) if snapshot.ratio > 0 else 0.0,
            points=parameters.points if parameters else 0,
            width=parameters.width if parameters else 0,
            height=parameters.height if parameters else 0,
            frames_received=snapshot.frames_received,
            frames_lost=snapshot.frames_lost,
            frames_late=snapshot.frames_late,
            playout_delay_ms=snapshot.playout_delay_ms,
            jitter_ms=snapshot.jitter_ms,
            history=tuple(self._history),
            history_seconds=len(self._history) * HISTORY_EVERY_S,
        )

    def _state(self, now: float) -> str:
        if self._viewer.paused:
            return "paused"
        if self._inbound.silent(now):
            return "lost" if self._inbound.traffic.count else "waiting"
        return "no face" if self._inbound.presence is Presence.NO_FACE else "receiving"
