"""The viewer's controls: view, pause, saved images, recordings."""

from collections.abc import Callable
from pathlib import Path

from conf.errors import ConfError
from conf.output.media_writer import VideoWriter, next_free_path, save_image
from conf.output.motion_recorder import MotionRecorder
from conf.protocol.messages import MotionFrame
from conf.receiver.expression_overlay import ExpressionOverlay
from conf.receiver.key_bindings import action_of, apply_view_event
from conf.render.camera import ViewState
from conf.render.window import Window
from conf.render.window.input_events import KeyPressed

TOAST_S = 3.0
VIDEO_FPS = 30.0


class ViewerControls:
    """Processes the window's input events and keeps the state that they change."""

    def __init__(self, window: Window, folder: Path | None = None) -> None:
        """folder : of images and recordings; None is the current folder"""
        self.view = ViewState()
        self.paused = False
        self.quit_requested = False
        self.expressions = ExpressionOverlay()
        self._window = window
        self._folder = folder or Path()
        self._toast = ("", 0.0)
        self._save_requested = False
        self._video: VideoWriter | None = None
        self._motion: MotionRecorder | None = None

    def process_events(self, now: float) -> None:
        """Carry out the input events since the last frame."""
        for event in self._window.poll():
            self.view = apply_view_event(self.view, event)
            match action_of(event):
                case "quit":
                    self.quit_requested = True
                case "pause":
                    self.paused = not self.paused
                case "save image":
                    self._save_requested = True
                case "record video":
                    self._try(self._toggle_video, now)
                case "record motion":
                    self._try(self._toggle_motion, now)
                case "full screen":
                    self._window.toggle_full_screen()
                case "emotion" if isinstance(event, KeyPressed):
                    self.show_toast(self.expressions.play(int(event.key), now), now)

    def show_toast(self, text: str, now: float) -> None:
        """Show a message for TOAST_S seconds."""
        self._toast = (text, now + TOAST_S)

    def toast(self, now: float) -> str:
        """Return the message to show, empty for none."""
        text, until = self._toast
        return text if now < until else ""

    def on_motion(self, frame: MotionFrame, now: float) -> None:
        """Record the motion that is shown, if that is switched on."""
        if self._motion:
            self._motion.add(frame.displacements, frame.pose, now)

    def on_frame_drawn(self, now: float) -> None:
        """Save or record the frame in the window's framebuffer, if that is switched on."""
        if self._save_requested:
            self._save_requested = False
            self._try(self._save_image, now)
        if self._video:
            self._add_frame(self._video, now)

    def close(self) -> None:
        """Complete the recordings."""
        if self._motion:
            self._try(self._toggle_motion, 0.0)
        if self._video:
            self._video.close()
            self._video = None

    def _save_image(self) -> str:
        return f"saved {save_image(next_free_path(self._folder, 'conf', '.jpg'), self._window.read())}"

    def _toggle_video(self) -> str:
        if self._video is None:
            self._video = VideoWriter(next_free_path(self._folder, "conf", ".avi"), fps=VIDEO_FPS)
            return "recording; R stops"
        video, self._video = self._video, None
        return f"saved {video.close() or 'nothing'}"

    def _toggle_motion(self) -> str:
        if self._motion is None:
            self._motion = MotionRecorder()
            return "recording the motion; D stops"
        motion, self._motion = self._motion, None
        return f"saved {motion.save(next_free_path(self._folder, 'conf', '.dpc')) or 'nothing'}"

    def _add_frame(self, video: VideoWriter, now: float) -> None:
        try:
            video.write_at(self._window.read, now)
        except ConfError as error:
            self._video, reason = None, str(error)
            self._try(lambda: f"{reason}; saved {video.close() or 'nothing'}", now)

    def _try(self, task: Callable[[], str], now: float) -> None:
        """Show the message that a task returns, or its error: a full disk must not end the call."""
        try:
            text = task()
        except ConfError as error:
            text = str(error)
        self.show_toast(text, now)
