"""The loop of a relay: let its front work, and count; zenoh forwards in threads of its own."""

import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Protocol

from conf.relay.front import FrontCounts
from conf.relay.router import RouterState

COUNT_S = 5.0
LOG_S = 60.0
POLL_S = 0.5
UNITS_IN_MB = {"darwin": 1 << 20}  # of the peak memory: bytes there, KiB elsewhere


class CountingRouter(Protocol):
    """What the loop needs of a router."""

    def state(self) -> RouterState: ...


class CountingFront(Protocol):
    """What the loop needs of a front."""

    def step(self, seconds: float, /) -> None: ...
    def counts(self) -> FrontCounts: ...


@dataclass(frozen=True)
class RelayFigures:
    """The figures of a relay.

    members, max_members : sessions, now and at most; udp_links, tcp_links : of the members
    peers : other relays
    forwarded to stun_ignored : see FrontCounts
    cpu_s : of the process, all threads; memory_mb : peak, None if unknown
    """

    seconds: float
    members: int
    max_members: int
    udp_links: int
    tcp_links: int
    peers: int
    forwarded: int
    strangers: int
    excess: int
    overflows: int
    refused: int
    tcp_bytes: int
    tcp_pauses: int
    stun_answered: int
    stun_ignored: int
    cpu_s: float
    memory_mb: float | None


class RelayLoop:
    """Counts what a relay does. A program calls `run`, or `step` from a loop of its own."""

    def __init__(self, router: CountingRouter, front: CountingFront, on_log: Callable[[str], None]) -> None:
        """on_log : called with a line about the present load, at most once a minute, if it has changed"""
        self._router = router
        self._front = front
        self._on_log = on_log
        self._state = RouterState()
        self._max_members = 0
        self._began: float | None = None
        self._count_due = self._log_due = float("-inf")
        self._logged = RouterState()

    def run(
        self,
        *,
        seconds: float | None = None,
        should_continue: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> RelayFigures:
        """Step for `seconds` or until `should_continue` returns False. Returns the figures."""
        end = float("inf") if seconds is None else clock() + seconds
        while should_continue() and (now := clock()) < end:
            self.step(now)
            self._front.step(min(POLL_S, end - clock()))
        self._count()
        return self.figures(clock())

    def step(self, now: float) -> None:
        """Count if that is due."""
        if self._began is None:
            self._began = now
        if now >= self._count_due:
            self._count_due = now + COUNT_S
            self._count()
        if now >= self._log_due and self._state != self._logged:
            self._log_due, self._logged = now + LOG_S, self._state
            self._on_log(describe_state(self._state))

    def figures(self, now: float) -> RelayFigures:
        """Return the figures since the first step."""
        state = self._state
        return RelayFigures(
            seconds=now - (now if self._began is None else self._began),
            members=state.members,
            max_members=self._max_members,
            udp_links=state.udp,
            tcp_links=state.tcp,
            peers=state.peers,
            **asdict(self._front.counts()),
            cpu_s=time.process_time(),
            memory_mb=peak_memory_mb(),
        )

    def _count(self) -> None:
        self._state = self._router.state()
        self._max_members = max(self._max_members, self._state.members)


def describe_state(state: RouterState, /) -> str:
    """Return the load of a relay as a line of a log, without names, codes or addresses."""
    text = f"members: {state.members}, {state.udp} of them over UDP"
    return f"{text}; other relays: {state.peers}" if state.peers else text


def peak_memory_mb() -> float | None:
    """Return the largest resident memory of this process, MB; None where the system does not tell."""
    if sys.platform == "win32":
        return None
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNITS_IN_MB.get(sys.platform, 1 << 10)
