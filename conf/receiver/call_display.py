"""The drawing part of a loop: frames at their rate, messages in the window and on the terminal."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from conf.receiver.draw_schedule import DrawSchedule
from conf.receiver.heads.participant_heads import HeadOptions
from conf.receiver.viewer_controls import ViewerControls
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_status import UnknownCodecs
from conf.render.window import Window

HIDDEN_STEP_S = 0.1  # from step to step of a window that is not shown


@dataclass(frozen=True)
class LoopOptions:
    """Options of drawing.

    fps : maximum frame rate; a window on a display also waits for the display
    idle_text : message while there is no call
    on_frame : called with the window, its frame drawn but not yet presented, and the time
    on_event : called with a short text when a caller comes, goes, moves or has a wrong code, or the network fails
    draw_clock : seconds, to adapt the resolution to the time that drawing takes; None draws all in full
    sound : what the callers' voices are heard through, None for silence
    heads : the heads of participants; None for one face of all
    """

    fps: float
    idle_text: str = ""
    on_frame: Callable[[Window, float], None] | None = None
    on_event: Callable[[str], None] | None = None
    draw_clock: Callable[[], float] | None = None
    sound: CallSound | None = None
    heads: HeadOptions | None = None


class Composer(Protocol):
    """What draws a frame of a call.

    note : a lasting message, such as that of a network error; "" for none
    shows_somebody : whether the last frame shows a participant's motion
    """

    controls: ViewerControls
    note: str

    @property
    def shows_somebody(self) -> bool: ...
    def report(self, text: str, now: float, /) -> None: ...
    def draw(self, now: float, /) -> None: ...
    def present(self, now: float, /) -> None: ...
    def release(self) -> None: ...


class CallDisplay:
    """Draws a call into a window, frame by frame. The program calls `step`, at the end `close`."""

    def __init__(self, window: Window, composer: Composer, options: LoopOptions) -> None:
        self._window = window
        self._composer = composer
        self._options = options
        self._schedule = DrawSchedule(options.fps)
        self._unknown_codecs = UnknownCodecs()
        self._note = self._local = ""  # shown last

    @property
    def is_over(self) -> bool:
        """Whether the viewer has quit or closed the window."""
        return self._composer.controls.quit_requested or self._window.should_close

    @property
    def reports(self) -> list[str]:
        """Lines for the terminal about the files that the viewer has written."""
        return self._composer.controls.reports

    @property
    def shows_somebody(self) -> bool:
        """Whether the last frame shows a participant's motion."""
        return self._composer.shows_somebody

    def show(self) -> None:
        """Show the window, if it is hidden."""
        if not self._window.visible:
            self._window.visible = True

    def hide(self) -> None:
        """Hide the window."""
        self._window.visible = False

    def step(self, now: float, *, is_flood: bool = False) -> float:
        """Draw a frame if one is due and the window is shown. Returns the time of the next step.

        is_flood : whether more datagrams wait; see DrawSchedule
        """
        if not self._window.visible:
            return now + HIDDEN_STEP_S
        if self._schedule.is_due(now, is_flood=is_flood):
            self._composer.draw(now)
            if self._options.on_frame:
                self._options.on_frame(self._window, now)
            self._composer.present(now)
        return self._schedule.next_step(now)

    def report(self, text: str, now: float) -> None:
        """Show a text in the window and on the terminal."""
        self._composer.report(text, now)
        self._tell(text)

    def show_toast(self, text: str, now: float) -> None:
        """Show a text in the window only."""
        self._composer.controls.show_toast(text, now)

    def show_faults(self, note: str, now: float, *, in_call: bool, local: str = "") -> None:
        """Show why the network, the sound, the voice of a caller or a device of this machine fails.

        note : of the network, "" while it works; in_call : whether the end of a note is worth a line
        local : of a camera or microphone, "" while it works
        """
        sound = self._options.sound
        for text in self._unknown_codecs.new(sound):
            self.report(text, now)
        note = note or (sound.fault if sound else "")
        if bool(note) != bool(self._note) and (note or in_call):
            self._tell(note or "it works again")
        if local and not self._local:
            self._tell(local)
        self._note, self._local = note, local
        self._composer.note = note or local

    def _tell(self, text: str) -> None:
        if self._options.on_event:
            self._options.on_event(text)

    def close(self) -> None:
        """Complete the viewer's recordings and free everything on the graphics card."""
        self._composer.controls.close()
        self._composer.release()
