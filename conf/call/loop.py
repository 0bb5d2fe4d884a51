"""The loop of a call: capture, send, receive, draw and play, in one thread but for capture and loudspeaker."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass

from conf.call.capture_thread import CaptureThread
from conf.call.controls import LocalState
from conf.call.events import describe_event
from conf.call.self_view import SelfView
from conf.call.shared_objects import SharedObjectSender
from conf.errors import NetworkError
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.session.events import Connected, LossReason, SessionEnded
from conf.protocol.voice.formats import VoiceState
from conf.receiver.call_display import CallDisplay
from conf.receiver.voice.call_sound import CallSound
from conf.sender.face_capture import CaptureMode, send_motion
from conf.sender.voice.voice_poller import VoicePoller
from conf.sender.voice.voice_sender import VoiceSender
from conf.transport.exchange import DatagramExchange
from conf.transport.interface import Transport

POLL_S = 0.03  # what was captured waits no longer; the display draws as often
TALKING_POLL_S = 0.06  # while motion waits for the next voice packet anyway
LEAVING_POLL_S = 0.02
CAMERA_RETRY_S = 3.0  # between two attempts to open a camera that is missing


@dataclass(frozen=True)
class LocalEnd:
    """What belongs to the person at this end.

    state : what is switched on; keys and buttons may change it
    objects : of the portrait, whose sending the loop allows and forbids; self_view : is told what is sent
    voice : None to send none
    """

    capture: CaptureThread
    state: LocalState
    objects: SharedObjectSender
    self_view: SelfView
    voice: VoiceSender | None = None


class CallLoop:
    """One end of a call of two. A program calls `run`, or `step` from a loop of its own, then `close`.

    connected_at, drawn_at : times of the first connection and of the first image of the other participant, on the
        clock of the loop, None before
    path : how datagrams reach the other participant, or reached it last, such as "direct"; "" before
    peer_name : name of the other participant, also after it has left; "" if it gave none
    """

    def __init__(
        self,
        endpoint: CallEndpoint,
        socket: Transport,
        local: LocalEnd,
        *,
        display: CallDisplay | None = None,
        sound: CallSound | None = None,
    ) -> None:
        """display : None to draw nothing; sound : what the other's voice is heard through, None for silence"""
        self.connected_at: float | None = None
        self.drawn_at: float | None = None
        self._endpoint = endpoint
        self._socket = socket
        self._local = local
        self._display = display
        self._voice = VoicePoller(local.voice)
        self._is_calling = socket.remote is not None
        peers = None if self._is_calling else lambda: endpoint.callers
        self._exchange = DatagramExchange(socket, endpoint, peers=peers, lock=sound.lock if sound else None)
        self.peer_name = self.path = ""
        self._has_peer_left = False
        self._camera_due = 0.0  # when a camera that is missing is tried again
        self._is_hung_up = False

    @property
    def is_over(self) -> bool:
        """Whether somebody has hung up or the source has ended; who waits for calls goes on waiting."""
        return self._local.capture.ended or self._is_hung_up or (self._display is not None and self._display.is_over)

    def run(
        self,
        *,
        seconds: float | None = None,
        should_continue: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Step until the person hangs up, a clip ends, `seconds` have passed or `should_continue` returns False.

        Raises NetworkError when the network fails for good, the code is wrong or the other end refuses.
        """
        end = float("inf") if seconds is None else clock() + seconds
        while not self.is_over and should_continue() and (now := clock()) < end:
            due = self.step(now)
            if self.drawn_at == now:
                self.drawn_at = clock()  # drawing the first image takes a tenth of a second
            self._socket.wait(due - clock())

    def step(self, now: float) -> float:
        """Do what is due at `now`, seconds on a monotonic clock. Returns the time at which to call it again.

        Raises as `run`.
        """
        is_flood = self._exchange.receive(now)
        self._apply_state(now)
        for captured in self._local.capture.drain():
            if self._local.state.shows_face:
                send_motion(self._endpoint, captured, now)
                self._local.self_view.sent = captured.motion
        self._voice.poll(self._local.capture.source_time(now), self._endpoint, now)
        self._exchange.send(now)
        self._handle_events(now)
        poll_s = TALKING_POLL_S if self._endpoint.voice_state is VoiceState.TALKING else POLL_S
        due = now + min(poll_s, self._voice.wait_s(now))
        if self._display is None:
            return due
        local = self._local.capture.note or self._voice.note
        self._display.show_faults(self._exchange.note, now, in_call=bool(self._endpoint.callers), local=local)
        due = min(due, self._display.step(now, is_flood=is_flood))
        if self.drawn_at is None and self._display.shows_somebody:
            self.drawn_at = now
        return due

    def close(self, now: float, *, clock: Callable[[], float] = time.monotonic) -> None:
        """End the call and notify the other end, if that is possible: at most for a second."""
        with contextlib.suppress(NetworkError):
            self._socket.send(self._endpoint.close(now))
            while self._endpoint.is_leaving(now := clock()):
                self._exchange.receive(now)
                self._exchange.send(now)
                self._socket.wait(LEAVING_POLL_S)

    def _apply_state(self, now: float) -> None:
        """Carry out the switches."""
        self._watch_camera(now)
        state, mode = self._local.state, CaptureMode.ON if self._endpoint.streams else CaptureMode.PREVIEW
        is_tried = bool(state.camera and state.camera_fault) and now >= self._camera_due
        self._local.capture.set_mode(mode if state.shows_face or is_tried else CaptureMode.OFF)
        if not state.shows_face:
            self._endpoint.send_camera_off(now)
            self._local.self_view.clear()
        self._local.objects.is_allowed = self._local.state.portrait
        self._endpoint.set_portrait_allowed(self._local.state.portrait, now)
        self._local.capture.set_portrait(is_allowed=self._local.state.portrait)
        self._local.capture.set_fps(self._endpoint.outbound.profile.fps)
        if self._voice.note:
            self._local.state.has_microphone = False
        if self._local.voice:
            self._local.voice.muted = not self._local.state.microphone

    def _watch_camera(self, now: float) -> None:
        """Notice that the camera has failed, or works again."""
        state = self._local.state
        if fault := self._local.capture.pop_fault():
            if not state.camera_fault:
                self._report(fault, now)
            state.camera_fault, self._camera_due = fault, now + CAMERA_RETRY_S
        elif state.camera_fault and self._local.capture.is_working:
            state.camera_fault = ""

    def _handle_events(self, now: float) -> None:
        self.peer_name = self._endpoint.remote_state.name or self.peer_name
        for peer in self._endpoint.callers:
            self.path = self._socket.path_name(peer)
        while event := self._endpoint.next_event():
            if isinstance(event, Connected) and self._has_peer_left:
                self.peer_name = self._endpoint.remote_state.name  # whoever comes now may be somebody else
            text = describe_event(
                event,
                name=self.peer_name,
                is_calling=self._is_calling,
                nameplate=self._socket.nameplate,
                is_awaited=self._socket.others_wait,
            )
            if text:
                self._report(text, now)
            if isinstance(event, SessionEnded):
                self._has_peer_left = event.reason is not LossReason.REPLACED
                self._is_hung_up |= self._is_calling and event.reason is LossReason.HUNG_UP
        if self.connected_at is None and self._endpoint.streams:
            self.connected_at = now
            if self._display:
                self._display.show()
        if refused := self._exchange.pop_refused():
            self._report(refused, now)

    def _report(self, text: str, now: float) -> None:
        if self._display:
            self._display.report(text, now)
