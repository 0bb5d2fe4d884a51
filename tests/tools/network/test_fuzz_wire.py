"""A small dose of tools/network/fuzz_wire.py: every truncation of every golden file, and a few thousand damaged
datagrams."""

import random

from tools.network.fuzz_wire import LiveCall, datagrams, fuzz


def test_nothing_that_is_not_sealed_changes_a_call() -> None:
    result = fuzz(2000, seed=7)
    assert result["datagrams"] > 2000
    assert result["frames_received_meanwhile"] > 40
    assert result["bodies_refused"] > 0.5 * result["bodies"]


def test_no_genuine_datagram_is_thrown() -> None:
    call = LiveCall(1)
    call.play(20)
    assert call.genuine.isdisjoint(datagrams(call, 1000, random.Random(1)))
