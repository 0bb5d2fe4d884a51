"""Compose one frame of a call: the participants' faces, then statistics, names, help and messages over them."""

from conf.face.deformation.face_model import FaceModel
from conf.protocol.messages import MotionFrame
from conf.protocol.receiver_endpoint import ReceiverEndpoint
from conf.receiver.call_stats import CallStatsCollector
from conf.receiver.participant_grid import ParticipantGrid, Viewport
from conf.receiver.stats_overlay import draw_stats
from conf.receiver.viewer_controls import ViewerControls, help_lines
from conf.render.gpu_object import GpuObject
from conf.render.ui.hud import draw_help, draw_label, draw_toast
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.window import Window

TOAST_MARGIN = 10.0  # pixels at scale 1 below a message
HELP_OPACITY = 0.88  # more than other panels: the help may cover the statistics


class FrameComposer(GpuObject):
    """Draws frames of a call into a window.

    names : text of the label of each participant, by its session
    """

    def __init__(self, window: Window, face: FaceModel, endpoint: ReceiverEndpoint, *, idle_text: str = "") -> None:
        """idle_text : message while there is no call, such as where to call and with which code"""
        self.controls = ViewerControls(window)
        self.names: dict[int, str] = {}
        self._window = window
        self._endpoint = endpoint
        self._idle_text = idle_text
        self._grid = ParticipantGrid(window, face)
        self._overlay = ImGuiOverlay(window.ctx)
        self._stats = CallStatsCollector(endpoint)
        self._frames: dict[int, MotionFrame | None] = {}
        self._owned = (self._overlay, self._grid)

    def draw(self, now: float) -> None:
        """Process input and draw the frame at `now`; the window still has to present it."""
        controls, streams = self.controls, self._endpoint.streams
        controls.process_events(now)
        if not controls.paused:
            playouts = {session: stream.motion.frame_at(now) for session, stream in streams.items()}
            self._frames = {session: playout.frame if playout else None for session, playout in playouts.items()}
        frames = {s: frame and controls.add_emotions(frame, now) for s, frame in self._frames.items()}
        if first := next((frame for frame in frames.values() if frame), None):
            controls.on_motion(first, now)
        self._window.begin()
        for session, stream in streams.items():
            if stream.received_objects:  # one object per frame: the photo takes as long as several frames
                self._grid.receive_portrait_object(session, stream.received_objects.popleft())
        cells = self._grid.draw(frames, controls.view, now)
        with self._overlay.frame(self._window):
            self._draw_panels(cells, now)
        controls.on_frame_drawn(now)

    def present(self, now: float) -> None:
        """Present the frame."""
        self._window.end()
        self._stats.on_frame_drawn(now)

    def _draw_panels(self, cells: dict[int, Viewport], now: float) -> None:
        overlay, view, (width, height) = self._overlay, self.controls.view, self._window.size
        if len(cells) > 1:
            for session, (x, y, _, _) in cells.items():
                draw_label(overlay, self.names.get(session, ""), (x, height - y))
        if view.stats:
            draw_stats(overlay, self._stats.collect(now, paused=self.controls.paused))
        if view.help:
            draw_help(overlay, help_lines(), (width / 2, height / 2), opacity=HELP_OPACITY)
        if toast := self.controls.toast(now) or ("" if self._endpoint.streams else self._idle_text):
            draw_toast(toast, (width / 2, height - TOAST_MARGIN * overlay.scale))
