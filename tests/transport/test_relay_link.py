import threading
from types import SimpleNamespace

import pytest
import zenoh

from conf.transport.link_policy import OPEN_TIMEOUTS_S
from conf.transport.relay_link import RelayLink
from tests.support.relay import wait_until

FAULT = "the relay does not answer"


class FakeSession:
    """A session with links of these kinds."""

    def __init__(self, kinds: str) -> None:
        self.is_closed = False
        self.set_links(kinds)

    def set_links(self, kinds: str) -> None:
        links = [SimpleNamespace(dst=f"{kind}/192.0.2.1:7447") for kind in kinds.split()]
        self.info = SimpleNamespace(links=lambda: links)

    def close(self) -> None:
        self.is_closed = True


class Stage:
    """A link whose attempts to open have these results: kinds of links, "" for a failure."""

    def __init__(self, *results: str) -> None:
        self.results = list(results)
        self.sessions: list[FakeSession] = []
        self.timeouts: list[float] = []
        self.used: list[FakeSession] = []
        self.link = RelayLink(self._open, self.used.append, FAULT)  # type: ignore[arg-type]

    def _open(self, timeout_s: float) -> FakeSession:
        self.timeouts.append(timeout_s)
        kinds = self.results.pop(0) if self.results else ""
        if not kinds:
            raise zenoh.ZError("unable to connect")
        self.sessions.append(FakeSession(kinds))
        return self.sessions[-1]


@pytest.mark.slow
def test_a_session_is_opened_after_failures_and_closed() -> None:
    stage = Stage("", "", "tcp udp")
    stage.link.start()
    wait_until(lambda: stage.link.kinds)
    assert stage.link.kinds == {"tcp", "udp"} and stage.link.fault == ""
    assert stage.used == stage.sessions and not stage.used[0].is_closed
    assert stage.timeouts == list(OPEN_TIMEOUTS_S[:3])
    stage.link.close()
    assert stage.used[0].is_closed


@pytest.mark.slow
def test_a_session_that_has_lost_a_link_is_replaced() -> None:
    stage = Stage("tcp udp", "tcp udp")
    stage.link.start()
    wait_until(lambda: stage.link.kinds)
    stage.sessions[0].set_links("udp")
    wait_until(lambda: len(stage.used) == 2 and stage.sessions[0].is_closed)
    wait_until(lambda: stage.link.kinds == {"tcp", "udp"})
    stage.sessions[1].set_links("")
    wait_until(lambda: stage.link.fault == FAULT)
    assert stage.link.kinds == frozenset()
    stage.link.close()


@pytest.mark.slow
def test_tasks_run_in_the_thread_and_only_so_many_wait() -> None:
    stage, release, ran = Stage("tcp udp"), threading.Event(), threading.Event()
    stage.link.start()
    wait_until(lambda: stage.link.kinds)
    assert stage.link.call(lambda _: _wait(release))
    accepted = sum(stage.link.call(lambda _: ran.set()) for _ in range(200))
    assert accepted < 100
    release.set()
    assert ran.wait(10)
    stage.link.close()


@pytest.mark.slow
def test_why_the_first_attempt_fails_is_found_out_once() -> None:
    stage, asked, answer = Stage("", "", "tcp udp"), list[str](), threading.Event()

    def explain() -> str:
        asked.append(stage.link.fault)
        _wait(answer)
        return "it refuses"

    stage.link._explain = explain
    stage.link.start()
    wait_until(lambda: asked)
    assert asked == [FAULT] == [stage.link.fault]
    answer.set()
    wait_until(lambda: stage.link.fault == "it refuses")
    wait_until(lambda: stage.link.kinds)
    assert stage.link.fault == ""
    stage.sessions[0].set_links("")
    wait_until(lambda: stage.link.fault == "it refuses")
    assert len(asked) == 1
    stage.link.close()


def _wait(event: threading.Event) -> None:
    assert event.wait(10)


def test_a_link_that_was_never_started_can_be_closed() -> None:
    Stage().link.close()


@pytest.mark.slow
def test_a_session_that_breaks_while_it_is_prepared_is_closed_and_opened_again() -> None:
    stage, used = Stage("tcp udp", "tcp udp"), list[object]()

    def prepare(session: object) -> None:
        used.append(session)
        if len(used) == 1:
            raise zenoh.ZError("session closed")

    stage.link._on_open = prepare
    stage.link.start()
    wait_until(lambda: stage.link.kinds)
    assert used == stage.sessions and [session.is_closed for session in stage.sessions] == [True, False]
    stage.link.close()
