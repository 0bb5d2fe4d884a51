import sys

import pytest

from conf.relay.front import FrontCounts
from conf.relay.loop import LOG_S, RelayLoop, describe_state, peak_memory_mb
from conf.relay.router import RouterState

IDLE, BUSY = RouterState(), RouterState(members=4, udp=3, tcp=4)


class FakeRouter:
    """A router whose counts a test sets."""

    def __init__(self) -> None:
        self.counts = IDLE

    def state(self) -> RouterState:
        return self.counts


class FakeFront:
    """A front without sockets."""

    def __init__(self) -> None:
        self.now_counts = FrontCounts()

    def step(self, seconds: float, /) -> None:
        assert seconds >= 0

    def counts(self) -> FrontCounts:
        return self.now_counts


class Stage:
    """A loop with a router and a front that a test sets."""

    def __init__(self) -> None:
        self.router, self.front, self.lines = FakeRouter(), FakeFront(), list[str]()
        self.loop = RelayLoop(self.router, self.front, self.lines.append)


def test_members_are_counted_now_and_at_most() -> None:
    stage = Stage()
    stage.loop.step(100.0)
    stage.router.counts = BUSY
    stage.loop.step(101.0)  # too soon to count again
    assert stage.loop.figures(101.0).members == 0
    stage.loop.step(106.0)
    stage.router.counts = IDLE
    stage.front.now_counts = FrontCounts(stun_answered=3, excess=7)
    stage.loop.step(120.0)
    figures = stage.loop.figures(130.0)
    assert (figures.seconds, figures.members, figures.max_members) == (30, 0, 4)
    assert (figures.stun_answered, figures.excess) == (3, 7) and figures.cpu_s > 0


def test_the_log_has_a_line_a_minute_and_only_if_something_has_changed() -> None:
    stage = Stage()
    for now in range(0, 600, 5):
        stage.router.counts = BUSY if now > 100 else IDLE
        stage.loop.step(float(now))
    assert stage.lines == ["members: 4, 3 of them over UDP"]
    for now in range(600, 1200, 5):
        stage.router.counts = RouterState(members=now)
        stage.loop.step(float(now))
    assert len(stage.lines) == 1 + 600 / LOG_S


def test_other_relays_are_named_by_their_number_only() -> None:
    assert describe_state(RouterState(peers=2)) == "members: 0, 0 of them over UDP; other relays: 2"


def test_a_loop_runs_until_it_is_stopped() -> None:
    stage, steps = Stage(), iter([True, True, False])
    times = iter(range(100))
    figures = stage.loop.run(should_continue=lambda: next(steps), clock=lambda: float(next(times)))
    assert figures.seconds > 0
    assert stage.loop.run(seconds=0).max_members == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no such figure there")
def test_the_memory_of_a_process_is_in_megabytes() -> None:
    memory = peak_memory_mb()
    assert memory is not None and 10 < memory < 10_000
