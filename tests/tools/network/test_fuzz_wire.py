"""A short run of tools/network/fuzz_wire.py: every truncation of every golden file, and 2000 damaged datagrams."""

import random

import pytest

from tools.network.fuzz_wire import LiveCall, datagrams, fuzz


@pytest.mark.slow
def test_unsealed_datagrams_do_not_change_a_call() -> None:
    result = fuzz(2000, seed=7)
    assert result["datagrams"] > 2000
    assert result["frames_received_meanwhile"] > 40
    assert result["bodies_refused"] > 0.5 * result["bodies"]
    assert result["voice_frames"] > 500


def test_no_valid_datagram_is_among_the_damaged_ones() -> None:
    call = LiveCall(1)
    call.play(20)
    assert call.valid.isdisjoint(datagrams(call, 1000, random.Random(1)))
