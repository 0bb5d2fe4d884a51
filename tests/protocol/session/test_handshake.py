"""Keys: equal on both sides exactly if code, attempt and shares are, and all different."""

from dataclasses import astuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.protocol.session.drop_reasons import DatagramError, DropReason
from conf.protocol.session.handshake import proof, receiver_secrets, sender_secrets, sender_share
from tests.support.simulated_sessions import CODE, WRONG, seeded

ATTEMPT = b"attempt1"


def test_both_sides_have_the_same_secrets_and_no_two_are_equal() -> None:
    spake, share = sender_share(CODE, seeded("sender"))
    theirs, own = receiver_secrets(CODE, ATTEMPT, share, seeded("receiver"))
    ours = sender_secrets(spake, ATTEMPT, (share, own))
    assert ours == theirs
    assert len({*astuple(ours)}) == 4
    assert {len(secret) for secret in astuple(ours)} == {32}


@pytest.mark.parametrize(("code", "attempt"), [(WRONG, ATTEMPT), (CODE, b"attempt2")])
def test_another_code_or_attempt_gives_other_secrets(code: str, attempt: bytes) -> None:
    spake, share = sender_share(code, seeded("sender"))
    theirs, own = receiver_secrets(CODE, ATTEMPT, share, seeded("receiver"))
    ours = sender_secrets(spake, attempt, (share, own))
    assert not {*astuple(ours)} & {*astuple(theirs)}


@pytest.mark.slow
@given(st.binary(min_size=32, max_size=32))
def test_any_32_bytes_are_a_share_or_a_counted_error(share: bytes) -> None:
    try:
        receiver_secrets(CODE, ATTEMPT, share, seeded("receiver"))
    except DatagramError as error:
        assert error.reason is DropReason.SHARE


@pytest.mark.parametrize("y", [0, 1, 2**255 - 20, 2**255 - 19, 2**255 - 18, 2**255, 2**256 - 1])
def test_points_of_small_order_are_invalid_or_useless(y: int) -> None:
    """The receiver's secret scalar is part of the key: two receivers never have the same one."""
    found = set()
    for seed in range(2):
        try:
            found.add(receiver_secrets(CODE, ATTEMPT, y.to_bytes(32, "little"), seeded(seed))[0])
        except DatagramError as error:
            assert error.reason is DropReason.SHARE
    assert len(found) in (0, 2)


def test_a_forged_share_does_not_use_the_state_up() -> None:
    spake, share = sender_share(CODE, seeded("sender"))
    with pytest.raises(DatagramError):
        sender_secrets(spake, ATTEMPT, (share, bytes(32)))
    theirs, own = receiver_secrets(CODE, ATTEMPT, share, seeded("receiver"))
    assert sender_secrets(spake, ATTEMPT, (share, own)) == theirs


def test_a_reflected_share_is_refused() -> None:
    spake, share = sender_share(CODE, seeded("sender"))
    with pytest.raises(DatagramError):
        sender_secrets(spake, ATTEMPT, (share, share))


def test_the_receivers_proof_covers_the_session() -> None:
    assert proof(bytes(32), 1) != proof(bytes(32), 2)
