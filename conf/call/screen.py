"""What one frame of a call shows over the faces: words, buttons, one's own image."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from conf.call.controls import ButtonPlace
from conf.call.layout import CallLayout, CallSizes, lay_out_call
from conf.call.notice import draw_notice, notice_size
from conf.call.self_picture import SelfPicture
from conf.call.toolbar import Button, draw_toolbar, lay_out_buttons, toolbar_sizes
from conf.call.view import Notice
from conf.receiver.call_stats import CallStats
from conf.receiver.notifications import Notifications
from conf.receiver.panel_layout import MARGIN, Rect, shorten
from conf.receiver.stats_overlay import LinePart, draw_line, draw_stats, line_size, stats_size
from conf.render.ui.hud import draw_label, figure_width, label_size, padded
from conf.render.ui.imgui_overlay import ImGuiOverlay

NAME_WIDTH = 0.45  # of the window's width, at most
MESSAGE_WIDTH = 0.6  # the same of a message's line


@dataclass(frozen=True)
class CallScreen:
    """The content of a frame; its methods are called inside `overlay.frame`.

    status : the line about the call; stats : what it costs, None while that is closed
    name : of the other participant, "" to show no label; name_note : what is to be known of it
    own_aspect : of one's own image, None to show none; own_caption : what is to be known of oneself
    messages : from top to bottom; recordings : key and running seconds of each
    """

    status: list[LinePart]
    stats: CallStats | None = None
    name: str = ""
    name_note: str = ""
    own_aspect: float | None = None
    own_caption: str = ""
    messages: Sequence[str] = ()
    notice: Notice | None = None
    buttons: Sequence[Button] = ()
    help: Sequence[tuple[str, str]] = ()
    recordings: Sequence[tuple[str, float]] = ()

    def layout(self, overlay: ImGuiOverlay) -> CallLayout:
        """Return where everything stands."""
        buttons = self._fitting_buttons(overlay)
        notifications = self._notifications(overlay).sizes(overlay)
        return lay_out_call(
            overlay.size,
            overlay.scale,
            CallSizes(
                status=line_size(overlay, self.status),
                toolbar=toolbar_sizes(buttons, overlay.scale)[0] if buttons else None,
                stats=stats_size(overlay, self.stats, is_open=True) if self.stats else None,
                notice=notice_size(overlay, self.notice) if self.notice else None,
                recording=notifications.recording,
                help=notifications.help,
                self_aspect=self.own_aspect,
                name=label_size(self._shown_name(overlay)) if self.name else None,
                messages=notifications.messages,
            ),
        )

    def draw_captured(self, overlay: ImGuiOverlay, layout: CallLayout) -> None:
        """Draw what saved images and recordings show: who it is."""
        if layout.name:
            draw_label(self._shown_name(overlay), (layout.name.left, layout.name.top))

    def draw_others(
        self, overlay: ImGuiOverlay, layout: CallLayout, own: SelfPicture, *, is_own_drawn: bool, hovered: str | None
    ) -> list[ButtonPlace]:
        """Draw all else and return where the buttons are.

        own : one's own image; is_own_drawn : the face is there already; hovered : action of the button under the mouse
        """
        if layout.own:
            own.draw(overlay, layout.own, self.own_caption, is_drawn=is_own_drawn)
        if layout.status:
            draw_line(overlay, self.status)
        if layout.stats and self.stats:
            draw_stats(overlay, self.stats, top=layout.stats.top)
        if layout.notice and self.notice:
            draw_notice(overlay, self.notice, (layout.notice.left, layout.notice.top))
        self._notifications(overlay).draw(overlay, layout)
        return self._draw_buttons(overlay, layout.toolbar, hovered)

    def _notifications(self, overlay: ImGuiOverlay) -> Notifications:
        width = max(MESSAGE_WIDTH * overlay.size[0] - padded(0, 0)[0], 1.0)
        return Notifications(self.messages, self.recordings, self.help, width)

    def _draw_buttons(self, overlay: ImGuiOverlay, rect: Rect | None, hovered: str | None) -> list[ButtonPlace]:
        buttons = self._fitting_buttons(overlay)
        if rect is None or not buttons:
            return []
        places = lay_out_buttons(rect, toolbar_sizes(buttons, overlay.scale)[1], overlay.scale)
        draw_toolbar(overlay, buttons, places, hovered=hovered)
        return [ButtonPlace(button.action, place) for button, place in zip(buttons, places, strict=True)]

    def _fitting_buttons(self, overlay: ImGuiOverlay) -> list[Button]:
        """Return the buttons for which there is room: without the names of their keys, then without the last but one.

        The last, by which one leaves, is kept longest.
        """
        room, buttons = overlay.size[0] - 2 * MARGIN * overlay.scale, [*self.buttons]
        if buttons and toolbar_sizes(buttons, overlay.scale)[0][0] > room:
            buttons = [replace(button, key="") for button in buttons]
        while len(buttons) > 1 and toolbar_sizes(buttons, overlay.scale)[0][0] > room:
            del buttons[-2]
        return buttons

    def _shown_name(self, overlay: ImGuiOverlay) -> str:
        """Return the text of the label: the note is kept if there is no room for both."""
        room = NAME_WIDTH * overlay.size[0] - padded(0, 0)[0]
        note = f"  {self.name_note}" if self.name_note else ""
        return shorten(shorten(self.name, room - figure_width(note), figure_width) + note, room, figure_width)
