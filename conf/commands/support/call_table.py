"""The table of a call's figures: one row a caller, and the total."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from conf.protocol.call_report import CallerReport, CallReport

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
    return table


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
