"""The viewer's controls: keys, view, pause, emotions, saved images, recordings."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from conf.audio.samples import SAMPLE_RATE
from conf.errors import AudioError, ConfError
from conf.face.animation.action_units import load_emotions
from conf.face.animation.expression_state import ExpressionState
from conf.face.animation.timed_expression import blend_without_doubling
from conf.output.image_writer import next_free_path, save_image
from conf.protocol.messages import MotionFrame
from conf.protocol.motion.inbound import ReceivedFrame
from conf.receiver.call_recorder import CallRecorder
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.render.camera import TOGGLES, ViewState
from conf.render.window import Window
from conf.render.window.input_events import Event, KeyPressed, apply_camera_event

if TYPE_CHECKING:
    from conf.output.video_writer import VideoWriter

TOAST_S = 3.0
VIDEO_FPS = 30.0

KeyTable = Mapping[str, tuple[str, str]]
# key -> (action, help text); keys with an empty help text share that of another key. Actions that are the name of a
# switch of ViewState toggle it.
KEYS: KeyTable = {
    "space": ("pause", "pause and go on"),
    "w": ("wireframe", "wireframe"),
    "p": ("points", "control points"),
    "m": ("stats", "call statistics in full, or one line"),
    "v": ("portrait", "the caller's own picture, or the head"),
    "c": ("centred", "centre the head, or as sent"),
    "s": ("save image", "save a picture (JPG)"),
    "r": ("record video", "record a clip (MP4), stop recording"),
    "d": ("record motion", "record the motion received (DPC), stop recording"),
    "1": ("emotion", "an emotion over the live motion"),
    **dict.fromkeys("23456", ("emotion", "")),
    "u": ("mute sound", "mute the sound, sound on"),
    "+": ("louder", "louder"),
    "=": ("louder", ""),
    "-": ("quieter", "quieter"),
    "f": ("full screen", "full screen"),
    "h": ("help", "this help"),
    "home": ("reset", "look straight again"),
    "0": ("reset", ""),
    "escape": ("quit", "quit"),
    "q": ("quit", ""),
}
HEAD_ONLY = {"wireframe": "wireframe", "points": "control points"}  # actions that show nothing on a photo
MOUSE_HELP = (("drag", "turn the head"), ("wheel", "zoom"), ("shift + drag", "move"))
KEY_LABELS = {"space": "Space", "home": "Home", "escape": "Esc"}


def action_of(event: Event, keys: KeyTable = KEYS) -> str | None:
    """Return the action of a key, None for other keys and events."""
    return keys.get(event.key, (None, ""))[0] if isinstance(event, KeyPressed) else None


def apply_view_event(view: ViewState, event: Event, keys: KeyTable = KEYS) -> ViewState:
    """Return the view changed by a key or the mouse; unchanged by other events."""
    action = action_of(event, keys)
    if action in TOGGLES:
        return view.toggled(str(action))
    return view.reset() if action == "reset" else apply_camera_event(view, event)


def help_lines(keys: KeyTable = KEYS) -> list[tuple[str, str]]:
    """Return keys and mouse gestures with their help texts; keys with the same action are on one line."""
    labels: dict[str, list[str]] = {}
    for key, (action, _) in keys.items():
        labels.setdefault(action, []).append(key_label(key))
    texts = {action: text for action, text in keys.values() if text}
    return [(", ".join(labels[action]), text) for action, text in texts.items()] + list(MOUSE_HELP)


def key_label(key: str) -> str:
    """Return the name of a key for the user."""
    return KEY_LABELS.get(key, key.upper())


def import_recording() -> None:
    """Import what recordings need, with PyAV, so that no frame has to wait for it later."""
    import_module("conf.output.video_writer")


class ViewerControls:
    """Processes the window's input events and keeps the state that they change.

    has_callers : whether there is a call whose motion can be recorded
    shows_photo : whether a caller's own photo is drawn instead of the head
    reports : lines for the terminal: the full path of each file written, and why the last one could not be
    """

    def __init__(
        self,
        window: Window,
        folder: Path | None = None,
        *,
        sound: CallSound | None = None,
        keys: KeyTable = KEYS,
        intercept: Callable[[Event, float], bool] = lambda event, now: False,
    ) -> None:
        """Watch a window.

        folder : of images and recordings; None is the current folder. sound : of the call, None if it is silent
        intercept : called with each event and the time, returns whether it has been dealt with
        """
        self.view = ViewState()
        self.paused = False
        self.quit_requested = False
        self.has_callers = False
        self.shows_photo = False
        self.reports: list[str] = []
        self._expressions = ExpressionState()
        self._window = window
        self._folder = folder or Path()
        self._sound = sound
        self._keys = keys
        self._intercept = intercept
        self._toast = ("", 0.0)
        self._save_requested = False
        self._video: VideoWriter | None = None
        self._motion: CallRecorder | None = None
        self._video_since = self._motion_since = 0.0

    @property
    def is_capturing(self) -> bool:
        """Whether the next frame is saved or recorded."""
        return self._save_requested or self._video is not None

    @property
    def is_recording(self) -> bool:
        """Whether a clip is being recorded."""
        return self._video is not None

    def recordings(self, now: float) -> list[tuple[str, float]]:
        """Return the key of each running recording and the seconds since its start."""
        started = (("R", self._video, self._video_since), ("D", self._motion, self._motion_since))
        return [(key, now - since) for key, recorder, since in started if recorder is not None]

    def process_events(self, now: float) -> None:
        """Carry out the input events since the last frame."""
        for event in self._window.poll():
            if self._intercept(event, now):
                continue
            self.view = apply_view_event(self.view, event, self._keys)
            if (action := action_of(event, self._keys)) is not None and isinstance(event, KeyPressed):
                self.run_action(action, now, key=event.key)

    def run_action(self, action: str, now: float, *, key: str = "") -> None:
        """Carry out an action of the table of keys; those of the view are left to `apply_view_event`.

        key : that was pressed
        """
        match action:
            case "wireframe" | "points" if self.shows_photo and getattr(self.view, action):
                self.show_toast(f"the photo has no {HEAD_ONLY[action]}: V shows the head", now)
            case "quit":
                self.quit_requested = True
            case "pause":
                self.paused = not self.paused
            case "save image":
                self._save_requested = True
            case "record video":
                self._video_since = now
                self._try(self._toggle_video, now)
            case "record motion":
                self._motion_since = now
                self._try(self._toggle_motion, now)
            case "mute sound":
                self._try(self._toggle_sound, now)
            case "louder":
                self._try(lambda: self._change_volume(+1), now)
            case "quieter":
                self._try(lambda: self._change_volume(-1), now)
            case "full screen":
                self._window.toggle_full_screen()
            case "emotion":
                self._play_emotion(int(key) - 1, now)

    def show_toast(self, text: str, now: float) -> None:
        """Show a message for TOAST_S seconds."""
        self._toast = (text, now + TOAST_S)

    def toast(self, now: float) -> str:
        """Return the message to show, empty for none."""
        text, until = self._toast
        return text if now < until else ""

    def add_emotions(self, frame: MotionFrame, now: float) -> MotionFrame:
        """Return a frame of received motion with the running emotions added."""
        self._expressions = self._expressions.without_finished(now)
        if not self._expressions.running:
            return frame
        return replace(frame, displacements=blend_without_doubling(frame.displacements, self._expressions.at(now)))

    def on_frames_received(self, session: int, frames: Iterable[ReceivedFrame], now: float) -> None:
        """Record the frames that have arrived from a caller, if that is switched on."""
        if self._motion:
            try:
                self._motion.add(session, frames)
            except ConfError as error:
                reason = str(error)
                self._try(lambda: f"{reason}; {self._toggle_motion()}", now)
            else:
                if self._motion.is_full:
                    self._try(lambda: f"{self._toggle_motion()} after an hour; D starts again", now)

    def on_frame_drawn(self, now: float) -> None:
        """Save or record the frame in the window's framebuffer, if that is switched on."""
        if self._save_requested:
            self._save_requested = False
            self._try(self._save_image, now)
        if self._video:
            self._add_frame(self._video, now)
        if self._video:
            self._add_sound(self._video, now)

    def close(self) -> None:
        """Complete the recordings."""
        if self._motion:
            self._report(self._toggle_motion)
        if self._video:
            self._report(self._toggle_video)

    def _play_emotion(self, index: int, now: float) -> None:
        emotions = load_emotions()
        self._expressions = self._expressions.play(emotions.names[index], emotions.displacements[index], now)
        self.show_toast(emotions.names[index], now)

    def _save_image(self) -> str:
        return self._saved([save_image(next_free_path(self._folder, "conf", ".jpg"), self._window.read())])

    def _toggle_video(self) -> str:
        if self._video is None:
            from conf.output.video_writer import VideoWriter

            rate = SAMPLE_RATE if self._sound else None
            self._video = VideoWriter(next_free_path(self._folder, "conf", ".mp4"), fps=VIDEO_FPS, audio_rate=rate)
            if self._sound:
                self._sound.record(True)
            return "recording; R stops"
        video, self._video = self._video, None
        if self._sound:
            self._sound.record(False)
        return self._complete(video)

    def _toggle_motion(self) -> str:
        if self._motion is None:
            if not self.has_callers:
                return "there is no call to record: press D again when someone has called"
            self._motion = CallRecorder(self._folder)
            return "recording the motion; D stops"
        motion, self._motion = self._motion, None
        return self._saved(motion.close()) or "no motion has arrived: nothing is saved"

    def _add_sound(self, video: "VideoWriter", now: float) -> None:
        for block in self._sound.recorded(now) if self._sound else ():
            video.write_audio(block.samples, block.timestamp)

    def _toggle_sound(self) -> str:
        mixer = self._mixer()
        mixer.muted = not mixer.muted
        return "sound off; U turns it on" if mixer.muted else "sound on"

    def _change_volume(self, steps: int) -> str:
        mixer = self._mixer()
        mixer.change_volume(steps)
        return f"volume {mixer.volume_db:+.0f} dB"

    def _mixer(self) -> VoiceMixer:
        if self._sound is None:
            raise AudioError("there is no sound: start without --no-sound, on a machine with a loudspeaker")
        return self._sound.mixer

    def _add_frame(self, video: "VideoWriter", now: float) -> None:
        try:
            video.write_at(self._window.read, now)
        except ConfError as error:
            self._video, reason = None, str(error)
            self._try(lambda: f"{reason}; {self._complete(video)}", now)

    def _complete(self, video: "VideoWriter") -> str:
        path = video.close()
        return self._saved([path]) if path else "nothing is saved"

    def _saved(self, paths: list[Path]) -> str:
        """Report files, and return the text about them for the window; empty for none."""
        self.reports += [f"saved {path}" for path in paths]
        return f"saved {' and '.join(map(str, paths))}" if paths else ""

    def _report(self, task: Callable[[], str]) -> None:
        """Complete a recording; an error is reported, as the window closes."""
        try:
            task()
        except ConfError as error:
            self.reports.append(str(error))

    def _try(self, task: Callable[[], str], now: float) -> None:
        """Show the message that a task returns, or its error: a full disk must not end the call."""
        try:
            text = task()
        except ConfError as error:
            text = str(error)
        self.show_toast(text, now)
