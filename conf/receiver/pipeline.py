"""The receiving loop: datagrams from the network in, frames in a window out, composed of parts that step."""

import time
from collections.abc import Callable

from conf.face.deformation.face_model import FaceModel
from conf.protocol.address import Address, RelayAddress, format_address, host_of
from conf.protocol.call_report import CallReport
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.protocol.session.events import AddressChanged, Connected, Event, SessionEnded, WrongCode
from conf.receiver.call_display import CallDisplay, LoopOptions
from conf.receiver.frame_composer import FrameComposer
from conf.render.window import Window
from conf.transport.exchange import DatagramExchange
from conf.transport.interface import Transport


class ReceiverLoop:
    """Shows all callers in a window. A program calls `run`, or `step` from a loop of its own, then `close`."""

    def __init__(
        self, window: Window, face: FaceModel, endpoint: ReceiverEndpoint, socket: Transport, options: LoopOptions
    ) -> None:
        self._endpoint = endpoint
        self._socket = socket
        self._composer = FrameComposer(
            window,
            face,
            endpoint,
            idle_text=options.idle_text,
            draw_clock=options.draw_clock,
            sound=options.sound,
            heads=options.heads,
        )
        self._display = CallDisplay(window, self._composer, options)
        self._direct: set[int] = set()  # sessions that have left the relay
        lock = options.sound.lock if options.sound else None
        self._exchange = DatagramExchange(socket, endpoint, peers=lambda: endpoint.callers, lock=lock)

    @property
    def is_over(self) -> bool:
        """Whether the viewer has quit or closed the window."""
        return self._display.is_over

    @property
    def reports(self) -> list[str]:
        """Lines for the terminal about the files that the viewer has written."""
        return self._display.reports

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
            return self._endpoint.report(now, path_name=self._socket.path_name)
        finally:
            self.close()

    def step(self, now: float) -> float:
        """Receive and send datagrams, then draw a frame if one is due. Returns the time of the next frame.

        Call it when a datagram has arrived, and at the latest at the time returned.
        """
        is_flood = self._exchange.receive(now)
        self._exchange.send(now)
        while event := self._endpoint.next_event():
            self._handle_event(event, now)
        self._composer.names = {
            session: participant_label(address, self._socket.path_name(address))
            for session, address in self._endpoint.addresses.items()
        }
        if refused := self._exchange.pop_refused():
            self._display.show_toast(refused, now)
        self._display.show_faults(self._exchange.note, now, in_call=bool(self._endpoint.callers))
        return self._display.step(now, is_flood=is_flood)

    def close(self) -> None:
        """Complete the viewer's recordings and free everything on the graphics card."""
        self._display.close()

    def _handle_event(self, event: Event, now: float) -> None:
        """Tell the viewer about a session event, but not that one direct path has replaced another."""
        over_relay = bool(self._socket.nameplate)
        if isinstance(event, Connected | AddressChanged):
            was_direct = event.session in self._direct
            self._direct.discard(event.session)
            if over_relay and not isinstance(event.address, RelayAddress):
                self._direct.add(event.session)
                if was_direct:
                    return
        if text := describe_event(event, over_relay=over_relay):
            self._display.report(text, now)


def participant_label(address: Address, path: str, /) -> str:
    """Return the label of a participant: its address, and over a relay, where it has none, the path."""
    return path if isinstance(address, RelayAddress) else format_address(address)


def describe_event(event: Event, *, over_relay: bool = False) -> str:
    """Return what a session event means for the viewer, "" for nothing. over_relay : calls begin there"""
    match event:
        case Connected(address=RelayAddress()):
            return "somebody calls"
        case Connected(address=address):
            return f"a call from {host_of(address)}"
        case AddressChanged(address=RelayAddress()):
            return "the direct path of a call has failed: it goes over the relay"
        case AddressChanged() if over_relay:
            return "a call goes directly now"
        case AddressChanged(address=address):
            return f"a caller has moved to {host_of(address)}"
        case SessionEnded():
            return "a call has ended"
        case WrongCode(tries_left=left, address=RelayAddress()):
            return f"a wrong code: {left} more tries for now"
        case WrongCode(tries_left=left, address=address):
            return f"a wrong code from {host_of(address)}: {left} more tries for now"
        case _:
            return ""
