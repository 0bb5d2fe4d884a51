"""Compose one frame of a call: the participants' faces, then the panels over them."""

from collections.abc import Callable

from conf.face.deformation.face_model import FaceModel
from conf.protocol.messages import MotionFrame
from conf.receiver.call_panels import CallPanels, NamePlate
from conf.receiver.call_stats import CallStatsCollector, ReceivingEnd
from conf.receiver.cell_cache import Viewport
from conf.receiver.heads.participant_heads import HeadOptions, look_of
from conf.receiver.panel_layout import Rect
from conf.receiver.participant_grid import ParticipantGrid
from conf.receiver.resolution_control import ResolutionControl
from conf.receiver.viewer_controls import ViewerControls, help_lines
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_status import VoiceStatus
from conf.render.gpu_object import GpuObject
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window import Window


class FrameComposer(GpuObject):
    """Draws frames of a call into a window.

    names : text of the label of each participant, by its session
    note : a lasting message, such as that of a network error; "" for none
    """

    def __init__(
        self,
        window: Window,
        face: FaceModel,
        endpoint: ReceivingEnd,
        *,
        idle_text: str = "",
        draw_clock: Callable[[], float] | None = None,
        sound: CallSound | None = None,
        heads: HeadOptions | None = None,
    ) -> None:
        """Prepare drawing.

        face : of everybody, or the default head if there are others
        idle_text : message while there is no call, such as where to call and with which code
        draw_clock : seconds, to measure how long drawing takes; given one, resolution and rate of the heads are adapted
            so that 30 frames a second are drawn
        sound : of the call, None if it is silent
        heads : the other heads, and whether they take on proportions
        """
        self.controls = ViewerControls(window, sound=sound)
        self.names: dict[int, str] = {}
        self.note = ""
        self._draw_clock = draw_clock
        self._resolution = ResolutionControl()
        self._window = window
        self._endpoint = endpoint
        self._idle_text = idle_text
        self._grid = ParticipantGrid(window, face, heads)
        self._overlay = ImGuiOverlay(window.ctx)
        self._stats = CallStatsCollector(endpoint, sound)
        self._frames: dict[int, MotionFrame | None] = {}
        self._owned = (self._overlay, self._grid)

    @property
    def shows_somebody(self) -> bool:
        """Whether the last frame shows a participant's motion."""
        return any(frame is not None for frame in self._frames.values())

    def report(self, text: str, now: float) -> None:
        """Show what has happened."""
        self.controls.show_toast(text, now)

    def draw(self, now: float) -> None:
        """Process input and draw the frame at `now`; the window still has to present it."""
        if self._draw_clock is None:
            self._draw(now)
            return
        began = self._draw_clock()
        self._draw(now)
        self._window.finish()
        self._grid.detail = self._resolution.on_frame(self._draw_clock() - began, cells=len(self._frames))

    def present(self, now: float) -> None:
        """Present the frame."""
        self._window.end()
        self._stats.on_frame_drawn(now)

    def _draw(self, now: float) -> None:
        controls, streams = self.controls, self._endpoint.streams
        controls.has_callers = bool(streams)
        controls.process_events(now)
        if not controls.paused:
            playouts = {session: stream.motion.frame_at(now) for session, stream in streams.items()}
            self._frames = {session: playout.frame if playout else None for session, playout in playouts.items()}
        frames = {s: frame and controls.add_emotions(frame, now) for s, frame in self._frames.items()}
        for session, stream in streams.items():
            controls.on_frames_received(session, stream.motion.received, now)
            stream.motion.received.clear()
        self._window.begin()
        for session, stream in streams.items():
            if stream.received_objects:  # one object per frame: the photo takes as long as several frames
                self._grid.receive_portrait_object(session, stream.received_objects.popleft())
        self._grid.withdrawn = {session for session, stream in streams.items() if stream.is_portrait_withdrawn}
        self._grid.looks = {session: look_of(stream) for session, stream in streams.items()}
        cells = self._grid.draw(frames, controls.view, now)
        controls.shows_photo = self._grid.shows_photo
        panels = self._panels(cells, now)
        if not controls.is_capturing:
            with self._overlay.frame(self._window):
                panels.draw(self._overlay)
            return
        with self._overlay.frame(self._window):
            panels.draw_captured(self._overlay)
        controls.on_frame_drawn(now)
        with self._overlay.frame(self._window):
            panels.draw_others(self._overlay)

    def _panels(self, cells: dict[int, Viewport], now: float) -> CallPanels:
        controls, height = self.controls, self._window.size[1]
        named = cells if len(cells) > 1 else {}
        idle_text = "" if self._endpoint.streams else self._idle_text
        stats = self._stats.collect(now, paused=controls.paused)
        voice = stats.voice or VoiceStatus()
        return CallPanels(
            stats=stats,
            is_open=controls.view.stats,
            names=[
                NamePlate(
                    self.names.get(session, ""),
                    Rect(x, height - y - cell_height, width, cell_height),
                    note=voice.notes.get(session, ""),
                    is_speaking=session == voice.loudest,
                )
                for session, (x, y, width, cell_height) in named.items()
            ],
            messages=[text for text in (self.note, controls.toast(now) or idle_text) if text],
            recordings=controls.recordings(now),
            help=help_lines() if controls.view.help else [],
        )
