"""The receiving loop: datagrams from the network in, frames in a window out."""

import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass

from conf.errors import NetworkError
from conf.face.deformation.face_model import FaceModel
from conf.protocol.call_report import CallReport
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.events import AddressChanged, Connected, Event, SessionEnded, WrongCode
from conf.receiver.frame_composer import FrameComposer
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_status import UnknownCodecs
from conf.render.window import Window
from conf.transport.fault_tolerance import NETWORK_LIMIT_S, FaultTolerance
from conf.transport.udp import ReceivedDatagram, UdpSocket

RECEIVE_BATCH = 512  # datagrams in one step: a few milliseconds of junk


@dataclass(frozen=True)
class LoopOptions:
    """Options of the receiving loop.

    fps : maximum frame rate; a window on a display also waits for the display
    idle_text : message while there is no call
    on_frame : called with the window, its frame drawn but not yet presented, and the time
    on_event : called with a short text when a caller comes, goes, moves or has a wrong code, or the network fails
    draw_clock : seconds, to adapt the resolution to the time that drawing takes; None draws all in full
    sound : what the callers' voices are heard through, None for silence
    """

    fps: float
    idle_text: str = ""
    on_frame: Callable[[Window, float], None] | None = None
    on_event: Callable[[str], None] | None = None
    draw_clock: Callable[[], float] | None = None
    sound: CallSound | None = None


class ReceiverLoop:
    """Shows all callers in a window. A program calls `run`, or `step` from a loop of its own, then `close`."""

    def __init__(
        self, window: Window, face: FaceModel, endpoint: ReceiverEndpoint, socket: UdpSocket, options: LoopOptions
    ) -> None:
        self._window = window
        self._endpoint = endpoint
        self._socket = socket
        self._options = options
        self._composer = FrameComposer(
            window, face, endpoint, idle_text=options.idle_text, draw_clock=options.draw_clock, sound=options.sound
        )
        self._unknown_codecs = UnknownCodecs()
        self._sound_lock = options.sound.lock if options.sound else nullcontext()
        # The socket is bound: what fails from now on may pass.
        self._sending, self._receiving = (FaultTolerance(NETWORK_LIMIT_S, has_worked=True) for _ in range(2))
        self._frame_due: float | None = None
        self._flood_deadline = 0.0
        self._drawing_since: float | None = None

    @property
    def is_over(self) -> bool:
        """Whether the viewer has quit or closed the window."""
        return self._composer.controls.quit_requested or self._window.should_close

    @property
    def reports(self) -> list[str]:
        """Lines for the terminal about the files that the viewer has written."""
        return self._composer.controls.reports

    def run(
        self,
        *,
        seconds: float | None = None,
        should_continue: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> CallReport:
        """Step until the window closes, `seconds` have passed or `should_continue` returns False, then close.

        Returns the figures of all calls.
        """
        began = now = clock()
        try:
            while not self.is_over and should_continue() and (seconds is None or now - began < seconds):
                due = self.step(now)
                self._socket.wait(due - clock())
                now = clock()
            return self._endpoint.report(now)
        finally:
            self.close()

    def step(self, now: float) -> float:
        """Receive and send datagrams, then draw a frame if one is due. Returns the time of the next frame.

        Call it when a datagram has arrived, and at the latest at the time returned. In a flood, when a step receives
        RECEIVE_BATCH datagrams, the frame waits, but no longer than drawing the last one took: a machine that draws
        slowly spends as much time on receiving.
        """
        if self._frame_due is None:
            self._frame_due = now
        if self._drawing_since is not None:
            interval = 1 / self._options.fps
            self._frame_due = max(self._frame_due + interval, now - interval)
            self._flood_deadline = max(self._frame_due, now + now - self._drawing_since)
            self._drawing_since = None
        is_flood = self._exchange_datagrams(now)
        if now >= (self._flood_deadline if is_flood else self._frame_due):
            self._drawing_since = now
            self._composer.draw(now)
            if self._options.on_frame:
                self._options.on_frame(self._window, now)
            self._composer.present(now)
            return now
        return self._frame_due

    def close(self) -> None:
        """Complete the viewer's recordings and free everything on the graphics card."""
        self._composer.controls.close()
        self._composer.release()

    def _exchange_datagrams(self, now: float) -> bool:
        """Process the datagrams received and send the answers. Returns whether a full batch was received."""
        datagrams = self._receive(now)
        with self._sound_lock:
            for data, address, queued_s in datagrams:
                self._endpoint.receive_datagram(data, address, now - queued_s)
        self._send(now)
        while event := self._endpoint.next_event():
            self._handle_event(event, now)
        for text in self._unknown_codecs.new(self._options.sound):
            self._report(text, now)
        sound_fault = self._options.sound.fault if self._options.sound else ""
        self._show_note(self._sending.note or self._receiving.note or sound_fault)
        return len(datagrams) == RECEIVE_BATCH

    def _receive(self, now: float) -> list[ReceivedDatagram]:
        try:
            datagrams = self._socket.receive(RECEIVE_BATCH)
        except NetworkError as error:
            self._receiving.on_failure(error, now)
            return []
        self._receiving.on_success()
        return datagrams

    def _send(self, now: float) -> None:
        """Send what is due. What cannot be sent to anybody but the callers ends no call: its sender may be forged."""
        with self._sound_lock:
            datagrams = self._endpoint.datagrams_to_send(now)
        is_to_caller = not self._endpoint.callers.isdisjoint(address for _, address in datagrams)
        try:
            self._socket.send(datagrams)
        except NetworkError as error:
            if is_to_caller:
                self._sending.on_failure(error, now)
            else:
                self._composer.controls.show_toast(str(error), now)
        else:
            if is_to_caller or not self._endpoint.callers:
                self._sending.on_success()

    def _show_note(self, note: str) -> None:
        """Show a note of the network in the window; report its first appearance and its end."""
        if self._options.on_event and bool(note) != bool(self._composer.note):
            if note or self._endpoint.callers:
                self._options.on_event(note or "the network works again")
        self._composer.note = note

    def _handle_event(self, event: Event, now: float) -> None:
        """Label the participants, and tell the viewer about a session event."""
        match event:
            case Connected(address=address):
                text = f"a call from {address[0]}"
            case AddressChanged(address=address):
                text = f"a caller has moved to {address[0]}"
            case SessionEnded(session=session):
                self._composer.names.pop(session, None)
                text = "a call has ended"
            case WrongCode(tries_left=left, address=address):
                text = f"a wrong code from {address[0]}: {left} more tries this minute"
            case _:
                return
        if isinstance(event, Connected | AddressChanged):
            self._composer.names[event.session] = "{}:{}".format(*event.address)
        self._report(text, now)

    def _report(self, text: str, now: float) -> None:
        """Show a text in the window and on the terminal."""
        self._composer.controls.show_toast(text, now)
        if self._options.on_event:
            self._options.on_event(text)
