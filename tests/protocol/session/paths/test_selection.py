"""Relay first, then direct, and back: which path a session uses, whatever the networks between its ends do."""

import random
from itertools import pairwise

import pytest

from conf.protocol.address import Address, RelayAddress
from conf.protocol.session.events import AddressChanged, Connected
from conf.protocol.session.paths.candidates import MAX_CANDIDATES, PATH_CANDIDATES, PathCandidates, encode_candidates
from conf.protocol.session.paths.selection import (
    ANNOUNCE_OFTEN,
    FALLBACK_S,
    FAST_S,
    MAX_ADDRESSES,
    NEW_ADDRESS_S,
    PROBED_S,
    SLOW_INTERVAL_S,
    SUSPECT_S,
    UNHEARD_S,
    Announcement,
    PathSelection,
)
from conf.protocol.session.paths.validation import PATH_PROBE
from tests.support.simulated_paths import CALLER, LOCAL, PUBLIC, STEP_S, WAITING, PathWorld
from tests.support.simulated_sessions import seeded

OTHER: Address = ("198.51.100.7", 40000)


def is_direct(world: PathWorld) -> bool:
    return world.paths == ("direct", "direct")


def connected(**options: bool | float) -> PathWorld:
    world = PathWorld(**options)  # type: ignore[arg-type]
    world.run(5, until=lambda: world.ends[0].session is not None and world.ends[1].session is not None)
    assert world.paths == ("relay", "relay")
    return world


def direct() -> PathWorld:
    world = connected()
    world.run(1, until=lambda: is_direct(world))
    world.run(3)
    assert is_direct(world)
    return world


def connections(world: PathWorld) -> int:
    return sum(isinstance(event, Connected) for events in world.events for event in events)


def content(world: PathWorld, end: int, since: float) -> list[str]:
    """Return over which path the content came that an end received."""
    return [
        "relay" if isinstance(address, RelayAddress) else "direct"
        for at, body, address in world.bodies[end]
        if at >= since and body[0] == 4
    ]


def test_two_cone_nats_give_way_to_a_direct_path() -> None:
    world = connected()
    assert world.run(1, until=lambda: is_direct(world)) < 0.5
    assert [end.peer for end in world.ends] == [PUBLIC[1], PUBLIC[0]]
    begin = world.now
    world.run(60)
    assert is_direct(world) and connections(world) == 2
    assert content(world, 0, begin + 1) == content(world, 1, begin + 1)
    assert set(content(world, 0, begin + 1)) == {"direct"} and len(content(world, 0, begin + 1)) > 110
    assert [[type(event) for event in events] for events in world.events] == [[Connected, AddressChanged]] * 2


def test_on_a_quiet_direct_path_nothing_is_spent_on_paths() -> None:
    world = direct()
    world.content_s = 1.0
    world.sent.clear()
    world.run(30)
    assert len(world.sent) == 60, "the content alone"


def test_two_symmetric_nats_stay_on_the_relay_and_try_seldom() -> None:
    world = connected(symmetric=True)
    world.run(FAST_S + 1)
    world.sent.clear()
    world.run(60)
    assert world.paths == ("relay", "relay") and connections(world) == 2
    probes = [data for _, end, target, data in world.sent if end == 0 and not isinstance(target, RelayAddress)]
    assert 14 <= len(probes) <= 60 / SLOW_INTERVAL_S + 1


def test_on_a_quiet_relay_nothing_is_spent_on_it() -> None:
    world = connected(symmetric=True)
    world.content_s = 1.0
    world.run(FAST_S + 1)
    world.sent.clear()
    world.run(30)
    assert sum(isinstance(target, RelayAddress) for _, _, target, _ in world.sent) == 60, "the content alone"


@pytest.mark.parametrize("deaf", [0, 1])
def test_an_end_learns_that_the_other_hears_nothing_over_the_relay(deaf: int) -> None:
    world = connected(symmetric=True)
    world.run(FAST_S + 1)
    unheard, last = world.ends[1 - deaf], world.now
    world.on_relay = lambda source, data: [] if source != deaf else world.forward(source, data)
    assert world.run(5, until=lambda: unheard.is_unheard) <= SUSPECT_S + UNHEARD_S + 0.3
    world.on_relay = world.forward
    heard = [end == deaf for at, end, _ in world.received if at > last + 0.1]
    assert heard and not any(heard) and not world.ends[deaf].is_unheard
    world.run(3, until=lambda: not unheard.is_unheard)
    world.run(10)
    assert not unheard.is_unheard and world.paths == ("relay", "relay") and connections(world) == 2


def test_an_end_that_was_busy_is_not_called_unheard() -> None:
    side = PathSelection(WAITING, 0.0, random=seeded(1), is_caller=True)
    for number in range(8):  # they have waited to be received
        side.receive(bytes((PATH_PROBE, *range(8))), WAITING, number * 0.25, is_newest=True)
    side.bodies_to_send(2.0)
    assert not side.is_unheard
    for now in (2.25, 2.5, 2.75):
        side.receive(bytes((PATH_PROBE, *range(8))), WAITING, now, is_newest=True)
        side.bodies_to_send(now)
    assert side.is_unheard
    side.bodies_to_send(4.0)
    assert not side.is_unheard


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_a_fifth_lost_on_the_relay_calls_an_end_unheard_once_in_five_minutes_at_most(seed: int) -> None:
    world = connected(symmetric=True)
    rng = random.Random(seed)
    world.is_lost = lambda: rng.random() < 0.2
    unheard = []
    for _ in range(600):
        world.run(0.5)
        unheard.append([end.is_unheard for end in world.ends])
    assert sum(now > before for a, b in pairwise(unheard) for before, now in zip(a, b, strict=True)) <= 1


def test_an_end_without_addresses_is_reached_where_its_probes_come_from() -> None:
    world = connected(announce=False)
    world.ends[0].set_candidates([PUBLIC[0]])
    world.nats[0].outbound(PUBLIC[1])  # that NAT admits the other end already
    assert world.run(2, until=lambda: is_direct(world)) < 1


@pytest.mark.parametrize("cut", [{0, 1}, {0}, {1}])
def test_when_the_direct_path_fails_the_same_session_is_back_on_the_relay(cut: set[int]) -> None:
    world = direct()
    begin, world.cut = world.now, cut
    assert world.run(5, until=lambda: world.paths == ("relay", "relay")) <= FALLBACK_S + 0.1
    world.run(2)
    for end in range(2):
        gap = next(at for at, _, address in world.bodies[end] if isinstance(address, RelayAddress) and at > begin)
        assert gap - begin < 2.0
    world.run(60)
    assert world.paths == ("relay", "relay") and connections(world) == 2
    world.cut = set()
    assert world.run(10, until=lambda: is_direct(world)) <= 2 * SLOW_INTERVAL_S
    assert connections(world) == 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_a_tenth_lost_changes_no_path(seed: int) -> None:
    world = direct()
    rng = random.Random(seed)
    world.is_lost = lambda: rng.random() < 0.1
    changes = [len(events) for events in world.events]
    world.run(300)
    assert is_direct(world) and [len(events) for events in world.events] == changes


def test_an_end_whose_address_changes_is_found_again() -> None:
    world = direct()
    world.nats[1] = type(world.nats[1])(("203.0.113.50", 1234))
    world.run(3)
    assert world.paths == ("relay", "relay")
    world.ends[1].set_candidates([("203.0.113.50", 1234), LOCAL[1]])
    assert world.run(2, until=lambda: is_direct(world)) < 1
    assert connections(world) == 2


def test_without_a_relay_no_address_is_announced() -> None:
    side = PathSelection(OTHER, 0.0, random=seeded(1), is_caller=True)
    side.set_local([PUBLIC[0]])
    assert side.bodies_to_send(0.0) == side.bodies_to_send(60.0) == []
    announced = PathCandidates(1, 0, True, (("192.0.2.12", 50002),))
    assert not side.receive(bytes((PATH_CANDIDATES,)) + encode_candidates(announced), OTHER, 0.0, is_newest=True)
    assert side.bodies_to_send(0.1) == []


def test_a_silent_path_is_probed_before_it_is_left() -> None:
    side = PathSelection(WAITING, 0.0, random=seeded(1), is_caller=True)
    side.address = PUBLIC[0]
    assert all(body[0] != PATH_PROBE for body, _ in side.bodies_to_send(SUSPECT_S - 0.01))
    assert (PATH_PROBE, PUBLIC[0]) in [(body[0], target) for body, target in side.bodies_to_send(SUSPECT_S)]
    assert side.is_direct
    side.bodies_to_send(FALLBACK_S)
    assert not side.is_direct and side.address == WAITING


def test_an_end_that_was_busy_asks_before_it_leaves_a_path() -> None:
    side = PathSelection(WAITING, 0.0, random=seeded(1), is_caller=True)
    side.address = PUBLIC[0]
    assert PUBLIC[0] in [target for body, target in side.bodies_to_send(5.0) if body[0] == PATH_PROBE]
    side.bodies_to_send(5.0 + PROBED_S - 0.01)
    assert side.is_direct
    side.receive(b"\x04content", PUBLIC[0], 5.4, is_newest=True)
    for busy in (6.3, 9.0):
        side.bodies_to_send(busy)
        assert side.is_direct
    side.bodies_to_send(9.0 + PROBED_S)
    assert not side.is_direct


def test_a_copy_on_the_relay_of_what_came_directly_moves_nothing() -> None:
    """A copy is dropped by the replay window, and one that is late here."""
    side = PathSelection(WAITING, 0.0, random=seeded(1), is_caller=False)
    side.address = PUBLIC[1]
    side.receive(b"\x04", PUBLIC[1], 0.1, is_newest=True)
    side.receive(b"\x04", WAITING, 0.2, is_newest=False)
    assert side.address == PUBLIC[1]
    side.receive(b"\x04", WAITING, 0.3, is_newest=True)
    assert side.address == WAITING


def test_content_over_the_relay_before_the_peer_has_moved_calls_nobody_back() -> None:
    side = PathSelection(WAITING, 0.0, random=seeded(1), is_caller=False)
    side.address = PUBLIC[1]
    side.receive(b"\x04", WAITING, 0.3, is_newest=True)
    assert side.address == PUBLIC[1] and [body for body, _ in side.bodies_to_send(0.3) if body[0] == PATH_PROBE] == []


def test_the_callers_and_the_called_do_not_follow_each_other_for_ever() -> None:
    caller, called = (PathSelection(WAITING, 0.0, random=seeded(n), is_caller=n == 0) for n in range(2))
    for side in (caller, called):
        side.address = PUBLIC[0]
        side.receive(b"\x04", LOCAL[0], 0.1, is_newest=True)
    assert caller.bodies_to_send(0.1)[0][0][0] == PATH_CANDIDATES
    assert next((body[0], target) for body, target in called.bodies_to_send(0.1)) == (PATH_PROBE, LOCAL[0])


def flood(side: PathSelection, seconds: float, *, is_distinct: bool = True) -> set[Address]:
    """Announce eight new addresses ten times a second. Returns the addresses that are probed."""
    probed: set[Address] = set()
    for number in range(round(seconds * 10)):
        base = number * MAX_CANDIDATES if is_distinct else 0
        addresses = tuple((f"198.51.{base // 200 % 256}.{base % 200 + i + 1}", 40000) for i in range(MAX_CANDIDATES))
        body = bytes((PATH_CANDIDATES,)) + encode_candidates(PathCandidates(number % 127 + 1, 1, True, addresses))
        side.receive(body, CALLER, number / 10, is_newest=True)
        for step in range(5):
            for sent, target in side.bodies_to_send(number / 10 + step * STEP_S):
                probed |= {target} if sent[0] == PATH_PROBE else set()
    return probed


def test_a_peer_that_announces_without_end_causes_few_addresses_to_be_probed() -> None:
    side = PathSelection(CALLER, 0.0, random=seeded(1), is_caller=False)
    probed = flood(side, 60)
    assert 1 <= len(probed) <= MAX_ADDRESSES + 60 / NEW_ADDRESS_S
    assert len(side._known) <= MAX_ADDRESSES and len(side._remote) <= MAX_CANDIDATES


def test_what_a_flood_of_announcements_is_answered_with_is_smaller_than_it() -> None:
    side = PathSelection(CALLER, 0.0, random=seeded(1), is_caller=False)
    side.set_local([PUBLIC[0], LOCAL[0]])
    sent = [0.0, 0.0]
    for number in range(1000):
        now = number / 100
        body = bytes((PATH_CANDIDATES,)) + encode_candidates(PathCandidates(number % 127 + 1, 0, True, ()))
        side.receive(body, CALLER, now, is_newest=True)
        sent[0] += len(body)
        sent[1] += sum(len(answer) for answer, _ in side.bodies_to_send(now))
    assert sent[1] < sent[0] / 4


@pytest.mark.parametrize("body", [b"", b"\x81", b"\x80\0\0", b"\x01\xff\0", b"\x01\0\x10"])
def test_malformed_announcements_change_nothing(body: bytes) -> None:
    side = PathSelection(CALLER, 0.0, random=seeded(1), is_caller=False)
    assert not side.receive(bytes((PATH_CANDIDATES,)) + body, CALLER, 0.0, is_newest=True)
    assert side._remote == []


def test_an_announcement_is_repeated_until_it_is_answered() -> None:
    mine, theirs = Announcement(), Announcement()
    mine.set_addresses((("192.0.2.11", 50001),))
    times = [step / 100 for step in range(3000) if mine.body(step / 100)]
    assert times[:3] == [0.0, 0.25, 0.5]
    assert len(times) == ANNOUNCE_OFTEN + int((30 - times[ANNOUNCE_OFTEN - 1]) / (SLOW_INTERVAL_S + 0.25))
    theirs.receive(PathCandidates(1, 0, True, ()), 30.0)
    assert theirs.body(30.0) is not None
    mine.receive(PathCandidates(1, 1, True, ()), 30.0)
    assert mine.body(31.0) is not None, "asked"
    assert mine.body(32.0) is None


def test_other_addresses_are_another_revision() -> None:
    mine = Announcement()
    mine.set_addresses((("192.0.2.11", 50001),))
    assert mine.body(0.0) == bytes.fromhex("0e 81 00 10 c000020b c351")
    mine.receive(PathCandidates(5, 1, False, ()), 0.1)
    mine.set_addresses((("192.0.2.11", 50001),))
    assert mine.body(1.0) is None
    mine.set_addresses((("192.0.2.11", 50002),))
    assert mine.body(1.0) == bytes.fromhex("0e 82 05 10 c000020b c352")
    mine.receive(PathCandidates(5, 1, False, ()), 1.1)
    assert mine.body(2.0) is not None, "the old revision is not the new one"
