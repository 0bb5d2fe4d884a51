"""The table of a call's figures: one row a caller, and the total."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from conf.protocol.call_report import CallerReport, CallReport
    from conf.protocol.statistics import MediaBytes

NO_CALL = "no one has called"
COLUMNS = ("connected", "frames", "lost", "bytes", "kbit/s", "B a\nframe", "raw\nkbit/s", "raw\n: wire")


def call_table(report: CallReport, /) -> Table | str:
    """Return the figures of all calls as a table to print, or a sentence if there was no call."""
    from rich.table import Table
    from rich.text import Text

    if not report.callers:
        return NO_CALL
    table = Table(title="the call", title_justify="left", box=None, padding=(0, 0, 0, 1), show_edge=False)
    table.add_column("caller", overflow="fold", vertical="bottom")
    for name in COLUMNS:
        table.add_column(name, justify="right", no_wrap=True, vertical="bottom")
    for caller in report.callers:
        table.add_row(Text(caller.caller), *_cells(caller))
    table.add_row("total", *_cells(report), style="bold")
    table.caption = f"of the bytes: {media_text(report.media_bytes)}"
    table.caption_justify = "left"
    return table


def media_text(amounts: MediaBytes) -> str:
    """Return what part of the bytes carried what, in percent."""
    return ", ".join(f"{medium} {100 * n / max(amounts.total, 1):.0f} %" for medium, n in asdict(amounts).items())


def _cells(figures: CallerReport | CallReport) -> list[str]:
    counts = (figures.frames_received, figures.frames_lost, figures.wire_bytes)
    return [
        f"{figures.connected_s:,.1f} s",
        *(f"{count:,}" for count in counts),
        f"{figures.wire_kbps:,.1f}",
        f"{figures.wire_bytes_per_frame:,.1f}",
        f"{figures.raw_kbps:,.0f}",
        f"{figures.ratio:,.0f}",
    ]
