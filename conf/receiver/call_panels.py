"""The panels over the image of a call: statistics, names, messages, recording sign, help."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from conf.receiver.call_stats import CallStats
from conf.receiver.notifications import Notifications
from conf.receiver.panel_layout import MARGIN, PanelLayout, PanelSizes, Rect, free_left, lay_out, shorten
from conf.receiver.stats_overlay import draw_stats, draw_stats_line, stats_size
from conf.render.ui.hud import draw_label, figure_width, label_size, padded
from conf.render.ui.imgui_overlay import ImGuiOverlay


class NamePlate(NamedTuple):
    """The label of a participant.

    cell : of the participant; note : about its voice; is_speaking : whether it is the loudest
    """

    text: str
    cell: Rect
    note: str = ""
    is_speaking: bool = False


@dataclass(frozen=True)
class CallPanels:
    """What is shown over one frame.

    is_open : whether the statistics are a panel rather than one line
    names : of the participants that are labelled
    messages : from top to bottom
    recordings : key and running seconds of each
    help : keys and what they do; none while it is closed
    """

    stats: CallStats
    is_open: bool = False
    names: Sequence[NamePlate] = ()
    messages: Sequence[str] = ()
    recordings: Sequence[tuple[str, float]] = ()
    help: Sequence[tuple[str, str]] = ()

    def draw(self, overlay: ImGuiOverlay) -> None:
        """Draw all panels. Call it, as the next two, inside `overlay.frame`."""
        layout = self.layout(overlay)
        self._draw_captured(overlay, layout)
        self._draw_others(overlay, layout)

    def draw_captured(self, overlay: ImGuiOverlay) -> None:
        """Draw what saved images and recordings show: names, and the statistics if they are open."""
        self._draw_captured(overlay, self.layout(overlay))

    def draw_others(self, overlay: ImGuiOverlay) -> None:
        """Draw the panels that `draw_captured` leaves out."""
        self._draw_others(overlay, self.layout(overlay))

    def layout(self, overlay: ImGuiOverlay) -> PanelLayout:
        """Return where the panels stand."""
        return lay_out(overlay.size, overlay.scale, self._sizes(overlay))

    def _sizes(self, overlay: ImGuiOverlay) -> PanelSizes:
        notifications = self._notifications(overlay).sizes(overlay)
        return PanelSizes(
            stats=stats_size(overlay, self.stats, is_open=self.is_open),
            is_open=self.is_open,
            recording=notifications.recording,
            help=notifications.help,
            messages=notifications.messages,
            names=[(plate.cell, label_size(self.shown_name(plate))) for plate in self.names],
        )

    def _notifications(self, overlay: ImGuiOverlay) -> Notifications:
        stats = PanelSizes(stats_size(overlay, self.stats, is_open=self.is_open), self.is_open)
        free = overlay.size[0] - free_left(overlay.scale, stats) - 2 * MARGIN * overlay.scale
        return Notifications(self.messages, self.recordings, self.help, max(free - padded(0, 0)[0], 1.0))

    def shown_name(self, plate: NamePlate) -> str:
        """Return the text of a plate; the note is kept if there is no room for both. Call it inside `overlay.frame`."""
        room = plate.cell.width - 3 * padded(0, 0)[0] / 2
        if not plate.note:
            return shorten(plate.text, room, figure_width)
        note = f"  {plate.note}"
        return shorten(shorten(plate.text, room - figure_width(note), figure_width) + note, room, figure_width)

    def _draw_captured(self, overlay: ImGuiOverlay, layout: PanelLayout) -> None:
        for plate, rect in zip(self.names, layout.names, strict=True):
            if rect is not None:
                draw_label(self.shown_name(plate), (rect.left, rect.top), highlighted=plate.is_speaking)
        if self.is_open:
            draw_stats(overlay, self.stats)

    def _draw_others(self, overlay: ImGuiOverlay, layout: PanelLayout) -> None:
        if not self.is_open:
            draw_stats_line(overlay, self.stats)
        self._notifications(overlay).draw(overlay, layout)
