"""A sender's and a receiver's session over a network that loses, delays, copies and replays: a stateful property."""

from itertools import count

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from conf.protocol.address import Address
from conf.protocol.session.events import BodyReceived, Connected, Refused, WrongCode
from tests.protocol.session.test_server import mutations
from tests.support.simulated_sessions import RECEIVER, SENDER, World, at_once

ELSEWHERE = ("203.0.113.9", 40001)


COPIES = st.lists(st.sampled_from([0.0, 0.0, 0.2, 1.0]), max_size=3)


class Sessions(RuleBasedStateMachine):
    """One sender and a receiver over a network that loses, delays and copies, with replays, restarts and new addresses.

    A body is a number, sealed once. It must arrive at most once in its session, and only there.
    """

    @initialize()
    def connect(self) -> None:
        self.world = World(epoch_length=8)
        self.sender = self.world.add_sender(epoch_length=8)
        self.address: Address = SENDER
        self.bodies = count()
        self.sealed: list[tuple[bytes, bytes]] = []  # (body, datagram)
        self.restarts = self.moves = 0
        self.world.run(0.5)

    @rule(copies=COPIES)
    def send(self, copies: list[float]) -> None:
        body = b"%d" % next(self.bodies)
        sealed = self.sender.seal_body(body)
        if sealed is not None:
            self.sealed.append((body, sealed.datagram))
            self.world.delays = lambda _: copies
            self.world.send(sealed.datagram, self.address, RECEIVER)
            self.world.delays = at_once
            self.world.settle()

    @rule()
    def report(self) -> None:
        for session in list(self.world.receiver.sessions):
            sealed = self.world.receiver.seal_body(session, b"report")
            assert sealed is not None
            self.world.send(sealed.datagram, RECEIVER, sealed.address)
        self.world.settle()

    @precondition(lambda self: self.sealed)
    @rule(data=st.data(), elsewhere=st.booleans())
    def replay(self, data: st.DataObject, elsewhere: bool) -> None:
        """Only a datagram that had not arrived yet may have an effect."""
        body, datagram = data.draw(st.sampled_from(self.sealed))
        bodies, addresses = self.world.bodies(), self._addresses()
        self.world.send(datagram, ELSEWHERE if elsewhere else self.address, RECEIVER)
        self.world.settle()
        if body in bodies:
            assert (self.world.bodies(), self._addresses()) == (bodies, addresses)

    @rule(seconds=st.sampled_from([0.3, 2.0, 6.0, 31.0]), outage=st.booleans())
    def wait(self, seconds: float, outage: bool) -> None:
        self.world.unreachable = {RECEIVER, self.address} if outage else set()
        self.world.run(seconds)
        self.world.unreachable = set()

    @rule()
    def move(self) -> None:
        self.moves += 1
        new = ("203.0.113.1", self.moves)
        self.world.move_sender(self.address, new)
        self.address = new

    @precondition(lambda self: self.restarts < 3)
    @rule()
    def restart(self) -> None:
        self.restarts += 1
        self.world.restart_receiver(f"restart {self.restarts}", epoch_length=8)

    @rule(data=st.data())
    def junk(self, data: st.DataObject) -> None:
        damaged = data.draw(mutations([datagram for _, _, datagram in self.world.traffic[-50:]]))
        dropped = self.world.receiver.dropped.total()
        before = len(self.world.received[RECEIVER])
        self.world.send(damaged, ELSEWHERE, RECEIVER)
        self.world.settle()
        assert self.world.receiver.dropped.total() >= dropped
        assert len(self.world.received[RECEIVER]) == before

    @invariant()
    def every_body_arrives_at_most_once_and_in_its_session(self) -> None:
        arrived = [event.body for event in self.world.received[RECEIVER] if isinstance(event, BodyReceived)]
        assert len(arrived) == len(set(arrived))
        for session, counters in self._counters().items():
            assert len(counters) == len(set(counters)), session

    def _counters(self) -> dict[int, list[int]]:
        """Return the counters received since each session began."""
        counters: dict[int, list[int]] = {}
        for event in self.world.received[RECEIVER]:
            if isinstance(event, Connected):
                counters[event.session] = []
            elif isinstance(event, BodyReceived):
                counters[event.session].append(event.counter)
        return counters

    def _addresses(self) -> dict[int, Address]:
        return {session: peer.address for session, peer in self.world.receiver.sessions.items()}

    @invariant()
    def nothing_is_refused(self) -> None:
        events = self.world.events() + self.world.events(self.address)
        assert not any(isinstance(event, WrongCode | Refused) for event in events)

    def teardown(self) -> None:
        if not hasattr(self, "world"):
            return
        for _ in range(70):  # longer than CONFIRM_TIMEOUT_S and all silences together
            self.report()
            self.send([0.0])
            if self.sealed and self.world.bodies()[-1:] == [self.sealed[-1][0]]:
                break
            self.world.run(0.5)
        assert self.sender.session in self.world.receiver.sessions


TestSessions = pytest.mark.slow(Sessions.TestCase)
TestSessions.settings = settings(max_examples=10, stateful_step_count=15)
