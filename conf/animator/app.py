"""The animator's window: its frame loop, and what the keys ask of the window itself."""

import time
from pathlib import Path

import numpy as np

from conf.animator.background_fit import FitFunction
from conf.animator.controller import Controller
from conf.animator.face_document import FaceDocument
from conf.animator.gui.layout import SCALE, Layout
from conf.animator.gui.main import AnimatorGui
from conf.animator.keys import key_label
from conf.animator.viewport_controller import ViewportController, WindowCommand
from conf.errors import ConfError, explain
from conf.output.image_writer import next_free_path
from conf.output.video_writer import VideoWriter
from conf.render.ui.imgui_input import ImGuiInput, dropped_files
from conf.render.ui.imgui_overlay import ImGuiOverlay
from conf.render.ui.theme import BACKDROP, themed
from conf.render.window import Window

FPS = 60.0
CLIP_FPS = 30.0
FPS_SMOOTHING = 0.05  # weight of the newest frame in the displayed frame rate


class AnimatorApp:
    """One window and its controller."""

    def __init__(
        self, window: Window, document: FaceDocument, folder: Path | None = None, *, fit: FitFunction | None = None
    ) -> None:
        """Open a document.

        folder : for screenshots and recordings; None for the current one
        fit : finds control points; None if that is not available
        """
        window.close_on_escape = False
        self._window = window
        self._overlay = ImGuiOverlay(window.ctx)
        self._overlay.connect_clipboard(window)
        self._gui = AnimatorGui(self._overlay)
        self.controller = Controller(window.ctx, document, fit)
        self._viewport = ViewportController(self.controller)
        self._input = ImGuiInput()
        self._folder = folder or Path()
        self._start = time.monotonic()
        self._last, self._period = 0.0, 1 / FPS
        self._clip: VideoWriter | None = None

    @property
    def fps(self) -> float:
        """Frames per second, smoothed."""
        return 1 / max(self._period, 1e-3)

    def now(self) -> float:
        """Return the seconds since the window was opened: the clock of everything that moves."""
        return time.monotonic() - self._start

    def run(self) -> None:
        """Draw until the window is closed."""
        while not self._window.should_close:
            self.draw_frame()
            remaining = self._last + 1 / FPS - self.now()
            if remaining > 0:
                time.sleep(remaining)

    def draw_frame(self) -> None:
        """Process events and draw one frame."""
        now = self.now()
        self._period += FPS_SMOOTHING * (now - self._last - self._period)
        self._last = now
        window, controller = self._window, self.controller
        events = window.poll()
        is_closing, window.should_close = window.should_close, False
        scale = SCALE.scale(window.size, window.pixel_ratio)
        layout = Layout.of(window.size, scale)
        self._input.process_events(events)
        commands = self._viewport.process_events(events, layout, scale, now)
        if is_closing:  # by the window's own button
            commands.add("quit")
        for path in dropped_files(events):
            controller.open_file(Path(path), now)
        controller.update(now)
        self._gui.prepare(controller)
        window.begin(BACKDROP)
        self._draw_face(layout, now)
        self._record_clip(layout, now)
        with self._overlay.frame(window, scale=scale), themed(scale):
            if self._gui.draw(controller, self._viewport, layout, now, self.fps):
                commands.add("quit")
        self._run_window_commands(commands)
        window.end()

    def close(self) -> None:
        """Finish a clip, free everything."""
        if self._clip is not None:
            with self.controller.errors_as_notice():
                self._end_clip(self._clip)
        self._gui.release()
        self.controller.release()
        self._overlay.release()

    def _draw_face(self, layout: Layout, now: float) -> None:
        controller, framebuffer = self.controller, self._window.framebuffer
        vertices, sample = controller.deform(now)
        framebuffer.viewport = layout.face_viewport(self._window.size[1])
        controller.face.view.draw(vertices, sample.pose, controller.state.view, framebuffer)
        framebuffer.viewport = (0, 0, *self._window.size)

    def _run_window_commands(self, commands: set[WindowCommand]) -> None:
        if "quit" in commands and self.controller.request_quit():
            self._window.should_close = True
        if "full screen" in commands:
            self._window.toggle_full_screen()
        if "screenshot" in commands:
            self.controller.save_screenshot(self._folder)
        if "record" in commands:
            with self.controller.errors_as_notice():
                self._toggle_clip()

    def _toggle_clip(self) -> None:
        if self._clip is None:
            self._clip = VideoWriter(next_free_path(self._folder, "conf", ".mp4"), fps=CLIP_FPS)
            self.controller.notice = f"recording the face as MP4; {key_label('record')} stops"
        else:
            self._end_clip(self._clip)

    def _end_clip(self, clip: VideoWriter) -> None:
        self._clip = None
        if path := clip.close():
            self.controller.on_saved(path)

    def _record_clip(self, layout: Layout, now: float) -> None:
        """Add the face's part of the window to the clip."""
        if self._clip is None:
            return
        x, y, width, height = layout.face_viewport(self._window.size[1])
        bottom = self._window.size[1] - y
        face = slice(bottom - height, bottom), slice(x, x + width)
        try:
            self._clip.write_at(lambda: np.ascontiguousarray(self._window.read()[face]), now)
        except ConfError as error:  # a full disk ends the recording, not the program
            with self.controller.errors_as_notice():
                self._end_clip(self._clip)
            self.controller.notice = f"{explain(error)}; {self.controller.notice}"
