"""The figures of a call at its end, of both directions."""

from collections.abc import Callable
from dataclasses import dataclass

from conf.protocol.address import Address
from conf.protocol.call_endpoint import CallEndpoint
from conf.protocol.call_report import CallReport
from conf.sender.face_capture import FaceCapture


@dataclass(frozen=True)
class SentFigures:
    """What this end has sent, UDP/IP headers included; wire_kbps over the time for which it was connected."""

    frames_captured: int
    frames_tracked: int
    frames_sent: int
    wire_bytes: int
    wire_kbps: float
    tracker_ms_median: float
    round_trip_ms: float | None
    loss_percent: float | None


@dataclass(frozen=True)
class CallTimes:
    """When things happened, on the clock of the loop.

    began : the command was started; connected_at : for the first time; drawn_at : first image of the other participant
    """

    began: float
    connected_at: float | None
    drawn_at: float | None


@dataclass(frozen=True)
class CallFigures:
    """The figures of both directions.

    connecting_s, picture_s : from the start of the command until there was a connection, and until the other
        participant was drawn; None if that did not happen
    name : of the other participant, "" if it gave none
    path : over which datagrams went last: "direct", "relay", "relay over TCP", or "local network" before "direct"
        where there is no relay; "" without a call
    """

    connected_s: float
    connecting_s: float | None
    picture_s: float | None
    sent: SentFigures
    received: CallReport
    name: str = ""
    path: str = ""


def call_figures(
    endpoint: CallEndpoint,
    capture: FaceCapture,
    times: CallTimes,
    now: float,
    *,
    name: str = "",
    path: str = "",
    path_name: Callable[[Address], str] | None = None,
) -> CallFigures:
    """Return the figures of a call.

    name : of the other participant; path : over which datagrams went last; path_name : how an address is reached
    """
    received, link = endpoint.report(now, path_name=path_name), endpoint.status(now)
    seconds = received.connected_s
    sent = SentFigures(
        frames_captured=capture.frames,
        frames_tracked=capture.tracked,
        frames_sent=endpoint.outbound.frames_sent,
        wire_bytes=round(endpoint.traffic.total),
        wire_kbps=endpoint.traffic.total * 8 / 1000 / seconds if seconds else 0.0,
        tracker_ms_median=capture.tracker_ms,
        round_trip_ms=link.round_trip_ms,
        loss_percent=link.loss_percent,
    )
    return CallFigures(
        connected_s=seconds,
        connecting_s=_since(times.began, times.connected_at),
        picture_s=_since(times.began, times.drawn_at),
        sent=sent,
        received=received,
        name=name,
        path=path,
    )


def _since(began: float, at: float | None) -> float | None:
    return None if at is None else at - began
