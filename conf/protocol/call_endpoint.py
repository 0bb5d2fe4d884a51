"""One end of a call of two: it calls or is called, sends and receives. No I/O, no clock."""

from collections.abc import Callable
from dataclasses import replace

from conf.protocol.address import Address
from conf.protocol.call_report import CallLog, CallReport
from conf.protocol.messages import StreamParameters
from conf.protocol.participant.state import CameraState, RemoteState
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.receive_leg import ReceiveLeg
from conf.protocol.sender_connection import FAREWELL, SenderConnection
from conf.protocol.session.call_session import CallSession
from conf.protocol.session.events import AddressChanged, Connected, Event, LossReason, SessionEnded
from conf.protocol.session.handshake import RandomBytes
from conf.protocol.statistics import TrafficSnapshot, merge_snapshots
from conf.protocol.voice.formats import VoiceState


class CallEndpoint(SenderConnection):
    """A sender connection that also receives and can be called.

    streams : the receiving half of the call by session number, empty while there is no call
    """

    def __init__(
        self,
        *,
        code: str,
        parameters: StreamParameters,
        now: float,
        random: RandomBytes,
        remote: Address | None = None,
        rate: RateOptions | None = None,
        portrait: ObjectSender | None = None,
        name: str = "",
        head: int = 0,
    ) -> None:
        """remote : whom to call, None to wait to be called

        code : as normalise_code returns it; random : n -> n random bytes; name, head : of this participant
        """
        self._call = CallSession(code, random, now, remote=remote)
        super().__init__(self._call, parameters, now, rate=rate, portrait=portrait, name=name, head=head)
        self.streams: dict[int, ReceiveLeg] = {}
        self._log = CallLog()
        self._calls = 0
        self._ended_rejected = 0

    @property
    def rejected(self) -> int:
        """Number of datagrams dropped, for whatever reason."""
        running = sum(leg.rejected for leg in self.streams.values())
        return self._call.dropped.total() + self._ended_rejected + running

    @property
    def callers(self) -> set[Address]:
        """The address of the peer, if there is a call."""
        return {self._call.peer} if self._call.peer else set()

    @property
    def remote_state(self) -> RemoteState:
        """The state of the other participant, as far as known."""
        if not self.streams:
            return RemoteState("", CameraState.OFF, VoiceState.OFF, None)
        (stream,) = self.streams.values()
        return RemoteState(stream.name, stream.camera, stream.voice.state, stream.portrait_percent)

    def snapshot(self, now: float) -> TrafficSnapshot:
        """Return the traffic figures of the call; of a silent peer without rates, jitter and delay."""
        figures = [leg.snapshot(now) for leg in self.streams.values()]
        if any(leg.is_silent(now) for leg in self.streams.values()):
            figures = [replace(f, raw_kbps=0.0, jitter_ms=0.0, playout_delay_ms=0.0) for f in figures]
        return replace(merge_snapshots(figures), rejected=self.rejected)

    def report(self, now: float, *, path_name: Callable[[Address], str] | None = None) -> CallReport:
        """Return the figures of all calls so far, ended ones included. path_name : how an address is reached"""
        running = {session: leg.snapshot(now) for session, leg in self.streams.items()}
        return replace(self._log.report(running, now, path_name=path_name), rejected=self.rejected)

    def close(self, now: float) -> list[tuple[bytes, Address]]:
        """Return the datagrams that end the call, which is over then.

        They may be lost: as long as `is_leaving`, `datagrams_to_send` returns more of them.
        """
        datagrams = super().close(now)
        self._call.close(farewell=FAREWELL)
        self._process_events(0, now)
        return datagrams

    def is_leaving(self, now: float) -> bool:
        """Return whether the peer may not know yet that this end has hung up: until it answers, at most a second."""
        return self._call.is_leaving(now)

    def _apply(self, event: Event, now: float) -> None:
        super()._apply(event, now)
        match event:
            case Connected(session=session, address=address):
                self._log.on_connected(session, address, now)
            case AddressChanged(session=session, address=address):
                self._log.on_address_changed(session, address)
            case SessionEnded(session=session, reason=reason):
                leg = self.streams.pop(session)
                was_there = leg.last_received if reason is LossReason.IDLE else now
                self._log.on_ended(session, leg.snapshot(now), now if was_there is None else was_there)
                self._ended_rejected += leg.rejected

    def _new_stream(self, session: int) -> ReceiveLeg:
        self._calls += 1
        self.streams[session] = ReceiveLeg(receiver_id=self._calls)
        return self.streams[session]
