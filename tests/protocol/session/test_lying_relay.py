"""A relay that swaps, repeats, delays, drops and invents datagrams, answers for a peer and guesses words.

It can stop a call. It can never read, join or alter one.
"""

import random

import pytest

from conf.protocol.address import Address, RelayAddress
from conf.protocol.session.call_session import CallSession
from conf.protocol.session.client import SenderSession
from conf.protocol.session.events import Connected, WrongCode
from conf.protocol.session.flood_protection import MAX_WRONG_CODES, RELAY_CODES_PERIOD_S
from conf.protocol.session.pairing_code import WORDS
from tests.support.simulated_paths import CALLER, CODE, LOCAL, PUBLIC, WAITING, PathWorld
from tests.support.simulated_sessions import seeded

CONTENT = b"\x04content"
Copies = list[tuple[float, Address, int, bytes]]


class LyingRelay:
    """Does to each datagram whatever its random numbers say. seen : all that has passed"""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self.seen: list[tuple[int, bytes]] = []

    def __call__(self, source: int, data: bytes) -> Copies:
        """Return what it sends for a datagram from an end: (delay, source address, target end, data)."""
        self.seen.append((source, data))
        rng, honest = self._random, (WAITING, CALLER)[source]
        copies: Copies = [(rng.uniform(0, 0.1), honest, 1 - source, data)] if rng.random() < 0.8 else []
        match rng.randrange(6):
            case 0:  # repeat something old, to anybody, as from anybody
                _, old = rng.choice(self.seen)
                copies.append((rng.uniform(0, 5), RelayAddress("4711", f"m{rng.randrange(9)}"), rng.randrange(2), old))
            case 1:  # change a byte
                at = rng.randrange(len(data))
                copies.append((0.0, honest, 1 - source, data[:at] + rng.randbytes(1) + data[at + 1 :]))
            case 2:  # invent
                begin = rng.choice((b"\x93\x03", b"\x94\x03", b""))
                copies.append((0.0, honest, rng.randrange(2), begin + rng.randbytes(40)))
            case 3:  # send it back to where it came from
                copies.append((0.0, (WAITING, CALLER)[1 - source], source, data))
        return copies


def content(world: PathWorld, end: int) -> list[bytes]:
    return [body for _, body, _ in world.bodies[end] if body[0] == CONTENT[0]]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_whatever_it_does_only_what_an_end_has_sealed_is_received_and_once(seed: int) -> None:
    world = PathWorld(announce=False)
    world.on_relay = relay = LyingRelay(seed)
    world.run(60)
    for end in range(2):
        received = [body for _, body, _ in world.bodies[end]]
        assert set(content(world, end)) <= {CONTENT} and len(content(world, end)) <= 121
        assert all(body[0] in (CONTENT[0], 0x0C, 0x0D, 0x0E) for body in received)
        assert all(not isinstance(event, WrongCode) for event in world.events[end]), "a lie is no guess"
    assert content(world, 0) and content(world, 1), "most of the datagrams have passed"
    assert all(CONTENT not in data and CODE.encode() not in data for _, data in relay.seen)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_it_cannot_keep_a_call_from_a_direct_path_nor_call_it_back(seed: int) -> None:
    world = PathWorld()
    world.run(3)
    assert world.paths == ("direct", "direct")
    world.on_relay = relay = LyingRelay(seed)
    for source in range(2):
        for at, end, _, data in world.sent:
            if end == source and at > world.now - 5:
                relay.seen.append((source, data))  # as if it had seen the direct path too
    for _ in range(100):
        for delay, address, end, data in relay(0, relay.seen[0][1]) + relay(1, relay.seen[1][1]):
            world._fly(delay, end, address, data)
        world.run(0.3)
        assert world.paths == ("direct", "direct")
    assert sum(isinstance(event, Connected) for events in world.events for event in events) == 2


def test_it_sends_no_probes_to_anybody_that_the_ends_have_not_announced() -> None:
    world = PathWorld(symmetric=True)
    world.on_relay = LyingRelay(1)
    world.run(30)
    targets = {target[0] for _, _, target, _ in world.sent if not isinstance(target, RelayAddress)}
    assert targets <= {address[0] for address in (*PUBLIC, *LOCAL)}


def test_one_that_drops_all_stops_a_call_that_has_no_direct_path_and_nothing_more() -> None:
    world = PathWorld(symmetric=True)
    world.run(2)
    world.on_relay = lambda source, data: []
    world.run(40)
    assert world.paths == ("none", "none")
    world.on_relay = world.forward
    world.run(10)
    assert world.paths == ("relay", "relay")


def test_one_that_answers_for_a_peer_without_the_words_is_not_believed() -> None:
    """Each attempt of the caller tests one guess, and the caller stops at the first wrong one or waits 20 s."""
    impostor = CallSession("4711-acorn-tulip-zebra", seeded("impostor"), 0.0)
    caller = CallSession(CODE, seeded("caller"), 0.0, remote=WAITING)
    for step in range(200):
        now = step / 10
        for data, _ in caller.datagrams_to_send(now):
            impostor.receive_datagram(data, CALLER, now)
        for data, _ in impostor.datagrams_to_send(now):
            caller.receive_datagram(data, WAITING, now)
    assert caller.session is None and impostor.session is None and caller.seal_body(CONTENT) is None


def test_guesses_are_limited_however_many_members_it_invents() -> None:
    waiting = CallSession(CODE, seeded("waiting"), 0.0)
    tested, step = 0, 0
    for number in range(60):
        member = RelayAddress("4711", f"member{number}")
        guess = SenderSession(f"4711-acorn-tulip-{WORDS[number]}", WAITING, seeded(number), step / 10)
        for _ in range(10):
            step += 1
            now = step / 10
            for data, _ in guess.datagrams_to_send(now):
                waiting.receive_datagram(data, member, now)
            for data, target in waiting.datagrams_to_send(now):
                if target == member:
                    guess.receive_datagram(data, WAITING, now)
        tested += sum(isinstance(event, WrongCode) for event in iter(waiting.next_event, None))
    assert step / 10 < RELAY_CODES_PERIOD_S and tested == MAX_WRONG_CODES and waiting.session is None
