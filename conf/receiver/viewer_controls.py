"""What the viewer does with the picture: look from another side, pause, save pictures, record clips."""

from collections.abc import Callable
from pathlib import Path

from conf.errors import ConfError
from conf.output.media_writer import VideoWriter, next_free_path, save_picture
from conf.output.motion_recorder import MotionRecorder
from conf.protocol.messages import MotionFrame
from conf.receiver.expression_overlay import ExpressionOverlay
from conf.receiver.participant_grid import Window
from conf.render.camera import ViewState
from conf.render.window.input_events import KeyPressed, action_of, apply_camera_event

NOTICE_S = 3.0
CLIP_FPS = 30.0


class ViewerControls:
    """Follows the window's events and carries out what they ask for."""

    def __init__(self, window: Window, folder: Path | None = None) -> None:
        """folder : where pictures and clips go; None takes the current one"""
        self.view = ViewState()
        self.paused = False
        self.quit_requested = False
        self.expressions = ExpressionOverlay()
        self._window = window
        self._folder = folder or Path()
        self._notice = ("", 0.0)
        self._picture_wanted = False
        self._clip: ConstantRateRecorder | None = None
        self._motion: MotionRecorder | None = None
        self._actions: dict[str, Callable[[float], None]] = {
            "quit": self._quit,
            "pause": self._pause,
            "picture": self._want_picture,
            "record": self._record,
            "record motion": self._record_motion,
            "full screen": lambda _: window.toggle_full_screen(),
        }

    def take_events(self, now: float) -> None:
        """Do what the viewer asked for since the last picture."""
        for event in self._window.poll():
            self.view = apply_camera_event(self.view, event)
            act = self._actions.get(action_of(event) or "")
            if act:
                act(now)
            if isinstance(event, KeyPressed) and action_of(event) == "emotion":
                self.show_toast(self.expressions.play(int(event.key), now), now)

    def show_toast(self, text: str, now: float) -> None:
        """Show a line at the bottom for a moment."""
        self._notice = (text, now + NOTICE_S)

    def notice(self, now: float) -> str:
        """Return the line to show at the bottom, empty for none."""
        text, until = self._notice
        return text if now < until else ""

    def on_frame_drawn(self, now: float) -> None:
        """Save and record the picture that stands in the window's framebuffer."""
        if self._picture_wanted:
            self._picture_wanted = False
            self._try(
                lambda: f"saved {save_picture(next_free_path(self._folder, 'conf', '.jpg'), self._window.read())}", now
            )
        if self._clip:
            self._add(self._clip, now)

    def on_motion(self, frame: MotionFrame, now: float) -> None:
        """Record the motion that is shown."""
        if self._motion:
            self._motion.add(frame, now)

    def close(self) -> None:
        """Finish the recordings that are under way."""
        if self._motion:
            self._record_motion(0.0)
        if self._clip:
            self._clip.close()
            self._clip = None

    def _quit(self, now: float) -> None:
        self.quit_requested = True

    def _pause(self, now: float) -> None:
        self.paused = not self.paused

    def _want_picture(self, now: float) -> None:
        self._picture_wanted = True

    def _record(self, now: float) -> None:
        if self._clip:
            clip, self._clip = self._clip, None
            self._try(lambda: f"saved {clip.close() or 'nothing'}", now)
        else:
            self._try(self._start_recording, now)

    def _record_motion(self, now: float) -> None:
        if self._motion:
            motion, self._motion = self._motion, None
            self._try(lambda: f"saved {motion.close() or 'nothing'}", now)
        else:
            self._motion = MotionRecorder(next_free_path(self._folder, "conf", ".dpc"))
            self.show_toast("recording the motion; D stops", now)

    def _start_recording(self) -> str:
        self._clip = ConstantRateRecorder(next_free_path(self._folder, "conf", ".avi"))
        return "recording; R stops"

    def _add(self, clip: "ConstantRateRecorder", now: float) -> None:
        try:
            clip.add(self._window, now)
        except ConfError as error:
            self._clip, why = None, str(error)
            self._try(lambda: f"{why}; saved {clip.close() or 'nothing'}", now)

    def _try(self, task: Callable[[], str], now: float) -> None:
        """A full disk must not end a call: the viewer is told and the picture goes on."""
        try:
            text = task()
        except ConfError as error:
            text = str(error)
        self.show_toast(text, now)


class ConstantRateRecorder:
    """A clip of fixed frame rate from pictures that come when they are drawn."""

    def __init__(self, path: Path, *, fps: float = CLIP_FPS) -> None:
        self._recorder = VideoWriter(path, fps=fps)
        self._fps = fps
        self._began: float | None = None

    def add(self, window: Window, now: float) -> None:
        """Write the window's picture as often as the time since the last one asks for."""
        self._began = now if self._began is None else self._began
        due = int((now - self._began) * self._fps) + 1
        if self._recorder.frames < due:
            pixels = window.read()
            while self._recorder.frames < due:
                self._recorder.write(pixels)

    def close(self) -> Path | None:
        """Finish the file. Returns its path, None if it is empty."""
        return self._recorder.close()
