"""The receiving loop: datagrams from the network, pictures to a window.

The way of one frame is read here from top to bottom; every step it calls is a module of its own.
"""

import time
from collections.abc import Callable

from conf.face.deformation.face_model import FaceModel
from conf.protocol.messages import MotionFrame
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.events import AddressChanged, Connected, Event, SessionEnded, WrongCode
from conf.protocol.statistics import TrafficSnapshot
from conf.receiver.call_stats import CallStatsCollector
from conf.receiver.hud import draw_help, draw_label, draw_toast
from conf.receiver.participant_grid import ParticipantGrid, Viewport, Window
from conf.receiver.stats_overlay import draw_stats
from conf.receiver.viewer_controls import ViewerControls
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.transport.udp import UdpSocket

RECEIVE_BATCH = 512  # datagrams between two looks at the clock: a few milliseconds of junk


class ReceivingLoop:
    """Show everybody who calls over a link until the window is closed."""

    def __init__(
        self, window: Window, face: FaceModel, host: ReceiverEndpoint, link: UdpSocket, *, idle_text: str = ""
    ) -> None:
        """greeting : what the picture says while nobody has called: where, and with which code"""
        self._window = window
        self._stage = ParticipantGrid(window, face)
        self._overlay = ImGuiOverlay(window.ctx)
        self._viewer = ViewerControls(window)
        self._readings = CallStatsCollector(host)
        self._host = host
        self._link = link
        self._greeting = idle_text
        self._shown: dict[int, MotionFrame | None] = {}
        self._cells: dict[int, Viewport] = {}
        self._names: dict[int, str] = {}
        self._on_event: Callable[[str], None] | None = None

    def run(
        self,
        *,
        fps: float,
        seconds: float | None = None,
        keep_going: Callable[[], bool] = lambda: True,
        on_picture: Callable[[Window, float], None] | None = None,
        on_event: Callable[[str], None] | None = None,
    ) -> TrafficSnapshot:
        """Draw until the window closes, `seconds` have passed or `keep_going` says no.

        fps : pictures a second at the most; a window on a display also waits for the display
        on_picture : called with each picture in the window's framebuffer
        on_event : told in a few words who came, went or had the wrong code
        Returns the traffic's figures.
        """
        self._on_event = on_event
        began = due = time.monotonic()
        try:
            while not self._over(began, seconds) and keep_going():
                start = time.monotonic()
                self._draw(start, on_picture)
                drawn = time.monotonic()
                due = max(due + 1 / fps, drawn - 1 / fps)
                self._serve_until(due, flood_deadline=max(due, drawn + drawn - start))
            return self._host.snapshot(time.monotonic())
        finally:
            self._viewer.close()
            self._overlay.release()
            self._stage.release()

    def _over(self, began: float, seconds: float | None) -> bool:
        late = seconds is not None and time.monotonic() - began >= seconds
        return late or self._viewer.quit_requested or self._window.should_close

    def _serve_until(self, until: float, *, flood_deadline: float) -> None:
        """Take datagrams as they come until the next picture is due. Those that came while one was drawn have waited.

        patience : when there is more to take than that, as in a flood, it is taken until then: a machine that is slow
        at drawing spends as long on listening
        """
        while True:
            now = time.monotonic()
            datagrams = self._link.receive(RECEIVE_BATCH)
            for data, address, waited in datagrams:
                self._host.receive_datagram(data, address, now - waited)
            self._link.send(self._host.datagrams_to_send(now))
            while event := self._host.next_event():
                self._handle_event(event, now)
            if now >= (flood_deadline if len(datagrams) == RECEIVE_BATCH else until):
                return
            self._link.wait(until - now)

    def _handle_event(self, event: Event, now: float) -> None:
        match event:
            case Connected(session=session, address=address) | AddressChanged(session=session, address=address):
                self._names[session] = "{}:{}".format(*address)
            case SessionEnded(session=session):
                self._names.pop(session, None)
        text = describe_event(event)
        if text:
            self._viewer.show_toast(text, now)
            if self._on_event:
                self._on_event(text)

    def _draw(self, now: float, on_picture: Callable[[Window, float], None] | None) -> None:
        self._viewer.take_events(now)
        if not self._viewer.paused:
            playouts = {caller: inbound.frame_at(now) for caller, inbound in self._host.streams.items()}
            self._shown = {caller: playout.frame if playout else None for caller, playout in playouts.items()}
        feelings = self._viewer.expressions
        with_expressions = {caller: frame and feelings.apply(frame, now) for caller, frame in self._shown.items()}
        first = next((frame for frame in with_expressions.values() if frame), None)
        if first:
            self._viewer.on_motion(first, now)
        self._window.begin()
        for caller, inbound in self._host.streams.items():
            if inbound.received_objects:  # one part a picture: the first one takes as long as several pictures
                self._stage.receive_portrait_object(caller, inbound.received_objects.popleft())
        self._cells = self._stage.draw(with_expressions, self._viewer.view, now)
        self._draw_panels(now)
        self._viewer.on_frame_drawn(now)
        if on_picture:
            on_picture(self._window, now)
        self._window.end()
        self._readings.on_frame_drawn(now)

    def _draw_panels(self, now: float) -> None:
        with self._overlay.frame(self._window.framebuffer, self._window.size, self._window.pixel_ratio):
            if len(self._cells) > 1:
                for caller, (x, y, _, _) in self._cells.items():
                    draw_label(self._overlay, self._names.get(caller, ""), (x, self._window.size[1] - y))
            if self._viewer.view.meter:
                draw_stats(self._overlay, self._readings.collect(now, paused=self._viewer.paused))
            if self._viewer.view.help:
                draw_help(self._overlay)
            if notice := self._viewer.notice(now) or ("" if self._host.streams else self._greeting):
                draw_toast(self._overlay, notice)


def describe_event(event: Event) -> str:
    """Return what an event of the sessions means to the viewer."""
    match event:
        case Connected(address=address):
            return f"a call from {address[0]}"
        case SessionEnded():
            return "a call has ended"
        case AddressChanged(address=address):
            return f"a caller has moved to {address[0]}"
        case WrongCode(tries_left=left, address=address):
            return f"a wrong code from {address[0]}: {left} more tries this minute"
        case _:
            return ""
