"""A short run of tools/network/fuzz_peer.py: a peer with the code sends bodies of every kind to two victims."""

import pytest

from conf.errors import ProtocolError
from conf.protocol.wire import decode_body
from tools.network.fuzz_peer import BYE, HostileBodies, fuzz, is_bye


@pytest.mark.slow
def test_a_hostile_peer_is_counted_and_the_call_of_others_goes_on() -> None:
    result = fuzz(6000, seed=7)
    assert result["honest_frames_received"] == result["honest_frames_sent"] > 10
    assert min(result["connections"]) == 1
    assert min(result["rejected"]) > 300
    assert max(result["bytes_sent_to_the_peer"]) < 0.1 * min(result["bytes_sent_by_the_peer"])
    assert min(result["datagrams_to_pretended_addresses"]) > 0


@pytest.mark.slow
def test_bodies_are_of_every_kind_valid_and_malformed() -> None:
    bodies, valid, invalid = HostileBodies(1), set[type](), 0
    for _ in range(4000):
        body = bodies.next()
        assert not is_bye(body)
        try:
            valid.add(type(decode_body(body)))
        except ProtocolError:
            invalid += 1
    assert len(valid) >= 13 and invalid > 400
    assert is_bye(BYE) and is_bye(b"\x10\x04\x04") and not is_bye(b"")
