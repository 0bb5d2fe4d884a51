"""Messages, the recording sign and the help: what the windows of one caller and of several show alike."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from conf.receiver.panel_layout import Rect
from conf.render.ui.hud import Size, draw_help, draw_recording_sign, draw_toast, help_size, sign_size, toast_size
from conf.render.ui.imgui_overlay import ImGuiOverlay

HELP_OPACITY = 0.88  # more than other panels: many lines have to be read


class NotificationSizes(NamedTuple):
    """Pixels; None for what is not shown."""

    recording: Size | None
    help: Size | None
    messages: list[Size]


class NotificationLayout(Protocol):
    """Positions; None for what is not shown or has no room."""

    @property
    def recording(self) -> Rect | None: ...
    @property
    def help(self) -> Rect | None: ...
    @property
    def messages(self) -> Sequence[Rect | None]: ...


@dataclass(frozen=True)
class Notifications:
    """What is shown in one frame; the methods are called inside `overlay.frame`.

    messages : from top to bottom; max_width : pixels after which one is wrapped
    recordings : key and running seconds of each
    help : keys and what they do; none while it is closed
    """

    messages: Sequence[str]
    recordings: Sequence[tuple[str, float]]
    help: Sequence[tuple[str, str]]
    max_width: float

    def sizes(self, overlay: ImGuiOverlay) -> NotificationSizes:
        """Return the sizes of all."""
        return NotificationSizes(
            recording=sign_size(overlay, [*self.recordings]) if self.recordings else None,
            help=help_size(overlay, [*self.help]) if self.help else None,
            messages=[toast_size(text, max_width=self.max_width) for text in self.messages],
        )

    def draw(self, overlay: ImGuiOverlay, layout: NotificationLayout) -> None:
        """Draw all where there is room."""
        if layout.recording:
            draw_recording_sign(overlay, [*self.recordings], (layout.recording.left, layout.recording.top))
        if layout.help:
            centre = layout.help.left + layout.help.width / 2, layout.help.top + layout.help.height / 2
            draw_help(overlay, [*self.help], centre, opacity=HELP_OPACITY)
        for number, (text, rect) in enumerate(zip(self.messages, layout.messages, strict=True)):
            if rect:
                anchor = rect.left + rect.width / 2, rect.bottom
                draw_toast(text, anchor, max_width=self.max_width, name=f"message {number}")
