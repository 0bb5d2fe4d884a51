"""Figures of whole calls: one row a caller and a total, with rates over the time for which they were connected."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import chain

from conf.protocol.address import Address, format_address
from conf.protocol.statistics import MediaBytes, TrafficSnapshot, merge_snapshots

MAX_CALLERS = 100  # rows kept; more callers that have left are added up in one row
OTHERS = "others"


@dataclass(frozen=True)
class CallerReport:
    """The figures of one caller, UDP/IP headers included.

    caller : network address, the newest if it has changed
    connected : whether the caller is still there
    connected_s : seconds for which the caller was connected, all its calls together; rates are over this time
    wire_bytes_per_frame : bytes; wire_kbps, raw_kbps : kilobits (1,000 bits) a second; ratio : raw to wire
    media_bytes : wire_bytes by what they carry
    path : how datagrams reach the caller, or reached it last, such as "direct"; "" if that is not known
    """

    caller: str
    connected: bool
    connected_s: float
    frames_received: int
    frames_lost: int
    wire_bytes: int
    wire_kbps: float
    wire_bytes_per_frame: float
    raw_kbps: float
    ratio: float
    media_bytes: MediaBytes
    path: str = ""


@dataclass(frozen=True)
class CallReport(TrafficSnapshot):
    """The figures of all callers together, with rates over the time for which at least one was connected.

    jitter_ms, playout_delay_ms : the longest, each caller's at the end of its call
    """

    connected_s: float
    callers: tuple[CallerReport, ...]


@dataclass
class _Caller:
    """One row. ended : figures and seconds of its ended calls; since : start of its running calls, by session."""

    name: str
    address: Address
    ended: list[TrafficSnapshot] = field(default_factory=list)  # at most one: all ended calls together
    ended_s: float = 0.0
    since: dict[int, float] = field(default_factory=dict)


class CallLog:
    """Keeps the figures of all calls. A caller that calls again from the same address stays one caller."""

    def __init__(self) -> None:
        self._callers: list[_Caller] = []  # in the order of their first calls
        self._connected_s = 0.0
        self._connected_since = 0.0

    def on_connected(self, session: int, address: Address, now: float) -> None:
        """Begin a call."""
        if not self._is_anyone_connected():
            self._connected_since = now
        name = format_address(address)
        caller = next((caller for caller in self._callers if caller.name == name), None)
        if caller is None:
            caller = _Caller(name, address)
            self._callers.append(caller)
            self._limit()
        caller.since[session] = now

    def on_address_changed(self, session: int, address: Address) -> None:
        """Name a caller by its new address."""
        caller = self._caller_of(session)
        caller.name, caller.address = format_address(address), address

    def on_ended(self, session: int, figures: TrafficSnapshot, now: float) -> None:
        """End a call. now : when the caller was last there"""
        caller = self._caller_of(session)
        caller.ended_s += max(now - caller.since.pop(session), 0.0)
        caller.ended = [merge_snapshots([*caller.ended, figures])]
        if not self._is_anyone_connected():
            self._connected_s += max(now - self._connected_since, 0.0)

    def report(
        self, running: dict[int, TrafficSnapshot], now: float, *, path_name: Callable[[Address], str] | None = None
    ) -> CallReport:
        """Return the figures of all calls.

        running : figures of the calls that have not ended, by session; path_name : how an address is reached
        """
        figures = [[*c.ended, *(running[session] for session in c.since)] for c in self._callers]
        rows = [_row(c, merge_snapshots(f), now) for c, f in zip(self._callers, figures, strict=True)]
        if path_name:
            paths = ["" if c.name == OTHERS else path_name(c.address) for c in self._callers]
            rows = [replace(row, path=path) for row, path in zip(rows, paths, strict=True)]
        seconds = self._connected_s + (now - self._connected_since if self._is_anyone_connected() else 0.0)
        total = over_time(merge_snapshots(list(chain.from_iterable(figures))), seconds)
        return CallReport(**vars(total), connected_s=seconds, callers=tuple(rows))

    def _is_anyone_connected(self) -> bool:
        return any(caller.since for caller in self._callers)

    def _caller_of(self, session: int) -> _Caller:
        return next(caller for caller in self._callers if session in caller.since)

    def _limit(self) -> None:
        """Add up the callers that left first, if there are too many rows."""
        if len(self._callers) <= MAX_CALLERS:
            return
        gone = [caller for caller in self._callers if not caller.since]
        if len(gone) > 1:
            first, second = sorted(gone, key=lambda caller: caller.name != OTHERS)[:2]
            self._callers.remove(second)
            first.name, first.ended_s = OTHERS, first.ended_s + second.ended_s
            first.ended = [merge_snapshots([*first.ended, *second.ended])]


def over_time(figures: TrafficSnapshot, seconds: float) -> TrafficSnapshot:
    """Return figures whose rates are means over a time in seconds."""
    wire, raw = figures.wire_bytes, figures.raw_bytes_per_frame * figures.frames_received
    rates: Iterable[float] = (n / seconds if seconds > 0 else 0.0 for n in (figures.frames_received, wire, raw))
    fps, wire_rate, raw_rate = rates
    return replace(
        figures,
        fps=fps,
        wire_kbps=wire_rate * 8 / 1000,
        raw_kbps=raw_rate * 8 / 1000,
        media_bytes_per_second=figures.media_bytes.scaled(1 / seconds if seconds > 0 else 0.0),
    )


def _row(caller: _Caller, figures: TrafficSnapshot, now: float) -> CallerReport:
    seconds = caller.ended_s + sum(now - since for since in caller.since.values())
    mean = over_time(figures, seconds)
    return CallerReport(
        caller=caller.name,
        connected=bool(caller.since),
        connected_s=seconds,
        frames_received=figures.frames_received,
        frames_lost=figures.frames_lost,
        wire_bytes=figures.wire_bytes,
        wire_kbps=mean.wire_kbps,
        wire_bytes_per_frame=figures.wire_bytes_per_frame,
        raw_kbps=mean.raw_kbps,
        ratio=figures.ratio,
        media_bytes=figures.media_bytes,
    )
