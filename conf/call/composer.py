"""Compose one frame of a call: the other participant large, oneself in a corner, words, buttons."""

from collections.abc import Callable

from conf.call.controls import CALL_KEYS, CallControls, LocalState
from conf.call.link_state import LinkMonitor
from conf.call.screen import CallScreen
from conf.call.self_picture import SelfPicture
from conf.call.self_view import SelfView
from conf.call.toolbar import buttons_of
from conf.call.view import UNKNOWN, Waiting, own_notes, remote_notes, status_parts
from conf.face.deformation.face_model import FaceModel
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.messages import MotionFrame
from conf.protocol.participant.state import CameraState
from conf.protocol.receive_leg import ReceiveLeg
from conf.receiver.call_stats import CallStatsCollector
from conf.receiver.heads.participant_heads import HeadOptions, Look, look_of
from conf.receiver.participant_grid import BACKGROUND, ParticipantGrid
from conf.receiver.resolution_control import ResolutionControl
from conf.receiver.viewer_controls import ViewerControls, help_lines
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_status import is_known
from conf.render.gpu_object import GpuObject
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window import Window

OTHER_ID, SELF_ID = 0, -2  # participant numbers in the grid: the other, and oneself as the other sees it


class CallComposer(GpuObject):
    """Draws frames of a call into a window.

    note : a lasting message, such as that of a network error; "" for none
    """

    def __init__(
        self,
        window: Window,
        face: FaceModel,
        endpoint: CallEndpoint,
        state: LocalState,
        self_view: SelfView,
        *,
        waiting: Waiting,
        has_face: Callable[[], bool],
        path: Callable[[], str] = lambda: "",
        draw_clock: Callable[[], float] | None = None,
        sound: CallSound | None = None,
        is_interactive: bool = True,
        heads: HeadOptions | None = None,
        own_head: int = 0,
    ) -> None:
        """Prepare drawing.

        waiting : what to say while there is no call
        has_face : whether one's own face is being seen; path : over which the call goes
        draw_clock, sound : as in FrameComposer
        heads : as in FrameComposer; own_head : number of the head that this end has chosen, 0 for none
        is_interactive : whether somebody needs buttons and the own image; a clip that is being written does not
        """
        self.note = ""
        self._reported = ""  # what happened last
        self._has_face = has_face
        self._path = path
        self._own = CallControls(state)
        self.controls = ViewerControls(window, sound=sound, keys=CALL_KEYS, intercept=self._own.intercept)
        self._own.show_toast, self._own.run_action = self.controls.show_toast, self.controls.run_action
        self._window = window
        self._endpoint = endpoint
        self._state = state
        self._self_view = self_view
        self._waiting = waiting
        self._has_sound = sound is not None
        self._draw_clock = draw_clock
        self._is_interactive = is_interactive
        self._resolution = ResolutionControl()
        self._grid = ParticipantGrid(window, face, heads)
        self._own_head = own_head
        self._overlay = ImGuiOverlay(window.ctx)
        self._own_picture = SelfPicture(window.ctx, self_view)
        self._stats = CallStatsCollector(endpoint, sound)
        self._link = LinkMonitor()
        self._name = ""
        self._stream: ReceiveLeg | None = None  # of the last frame
        self._began_at: float | None = None
        self._frame: MotionFrame | None = None
        self._owned = (self._overlay, self._own_picture, self._grid)

    @property
    def shows_somebody(self) -> bool:
        """Whether the last frame shows the other participant's motion."""
        return self._frame is not None

    def report(self, text: str, now: float) -> None:
        """Show what has happened."""
        self._reported = text
        self.controls.show_toast(text, now)

    def draw(self, now: float) -> None:
        """Process input and draw the frame at `now`; the window still has to present it."""
        began = self._draw_clock() if self._draw_clock else 0.0
        stream = next(iter(self._endpoint.streams.values()), None)
        self.controls.has_callers = stream is not None
        self.controls.process_events(now)
        self._follow(stream)
        self._name = self._endpoint.remote_state.name or self._name
        self._began_at = None if stream is None else now if self._began_at is None else self._began_at
        self._window.begin()
        self._draw_other(stream, now)
        self._draw_screen(self._screen(stream, now), now)
        if self._draw_clock:
            self._window.finish()
            self._grid.detail = self._resolution.on_frame(self._draw_clock() - began, cells=1)

    def present(self, now: float) -> None:
        """Present the frame."""
        self._window.end()
        self._stats.on_frame_drawn(now)

    def _follow(self, stream: ReceiveLeg | None) -> None:
        """Forget the other participant's name and photo when a session begins: it may be somebody else's."""
        if stream is not None and stream is not self._stream:
            self._name = ""
            self._grid.forget(OTHER_ID)
        self._stream = stream

    def _draw_other(self, stream: ReceiveLeg | None, now: float) -> None:
        """Draw the other participant; without a call, nothing but a background."""
        if stream is None:
            self._frame, self.controls.shows_photo = None, False
            self._window.framebuffer.clear(*BACKGROUND)
            return
        playout = stream.motion.frame_at(now)
        is_off = self._endpoint.remote_state.camera is CameraState.OFF
        self._frame = playout.frame if playout and not is_off else None
        self.controls.on_frames_received(OTHER_ID, stream.motion.received, now)
        stream.motion.received.clear()
        if stream.received_objects:  # one object per frame: the photo takes as long as several frames
            self._grid.receive_portrait_object(OTHER_ID, stream.received_objects.popleft())
        self._grid.withdrawn = {OTHER_ID} if stream.is_portrait_withdrawn else ()
        own_fapu = self._endpoint.outbound.parameters.fapu
        self._grid.looks = {OTHER_ID: look_of(stream), SELF_ID: Look(self._own_head, own_fapu)}
        self._grid.draw({OTHER_ID: self._frame}, self.controls.view, now)
        self.controls.shows_photo = self._grid.shows_photo

    def _screen(self, stream: ReceiveLeg | None, now: float) -> CallScreen:
        """Return what is to be said and offered now."""
        controls, state, in_call = self.controls, self._state, stream is not None
        stats = self._stats.collect(now, paused=False)
        link = self._link.update(self._endpoint.status(now), stream, now)
        call_s = None if self._began_at is None else now - self._began_at
        toast = controls.toast(now)
        if not in_call and toast == self._reported:
            toast = ""  # the notice says it
        note = "" if stream is None else self._remote_note(stream, now)
        own = own_notes(state, has_face=self._has_face(), in_call=in_call)
        return CallScreen(
            status=status_parts(link, self._name, call_s, stats, path=self._path(), idle=self._waiting.state),
            stats=stats if controls.view.stats and in_call else None,
            name="" if stream is None else self._name or (UNKNOWN if note else ""),
            name_note=note,
            own_aspect=self._own_picture.aspect if self._shows_oneself() else None,
            own_caption="  ".join(["what is seen of you" if self._own.sees_sent else "you", *own]),
            messages=[text for text in (self.note, toast) if text],
            notice=None if in_call else self._waiting.notice(name=self._name, text=self._reported),
            buttons=buttons_of(state, is_recording=controls.is_recording, in_call=in_call)
            if self._is_interactive
            else [],
            help=help_lines(CALL_KEYS) if controls.view.help else [],
            recordings=controls.recordings(now),
        )

    def _shows_oneself(self) -> bool:
        """Return whether one's own corner is shown: not for a clip that has not begun or a recorded motion."""
        view, seen = self._self_view, self._own.sees_sent
        return self._is_interactive and (
            view.image is not None or not self._state.shows_face or (seen and view.sent is not None)
        )

    def _remote_note(self, stream: ReceiveLeg, now: float) -> str:
        """Return what is to be known of the other participant."""
        has_voice = self._has_sound and is_known(stream, now)
        state, shows_photo = self._endpoint.remote_state, self.controls.shows_photo
        return "  ".join(remote_notes(state, has_voice=has_voice, shows_photo=shows_photo))

    def _draw_screen(self, screen: CallScreen, now: float) -> None:
        overlay, controls = self._overlay, self.controls
        if controls.is_capturing:
            with overlay.frame(self._window):
                screen.draw_captured(overlay, screen.layout(overlay))
            controls.on_frame_drawn(now)
        is_own_drawn = self._draw_own_face(screen, now)
        with overlay.frame(self._window):
            layout = screen.layout(overlay)
            if not controls.is_capturing:
                screen.draw_captured(overlay, layout)
            self._own.buttons = screen.draw_others(
                overlay, layout, self._own_picture, is_own_drawn=is_own_drawn, hovered=self._own.hovered
            )

    def _draw_own_face(self, screen: CallScreen, now: float) -> bool:
        """Draw into one's own corner what the other sees. Returns whether that was wished and possible."""
        view = self._self_view
        if self._own.sees_sent:
            while view.objects:
                self._grid.receive_portrait_object(SELF_ID, view.objects.popleft())
        if not (self._own.sees_sent and self._is_interactive and self._state.shows_face and view.sent):
            return False
        with self._overlay.frame(self._window):
            rect = screen.layout(self._overlay).own
        if rect is None:
            return False
        cell = round(rect.left), round(self._window.size[1] - rect.bottom), round(rect.width), round(rect.height)
        self._grid.draw_inset(SELF_ID, view.sent, cell, now, photo=self._state.portrait)
        return True
