"""The receiving half: whatever is lost, late or forged, a frame is right or it is an error."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.codec import LIVE, NARROWBAND, PROFILES, RICH, Decoder, Encoder, MissingReferenceError, Profile
from conf.protocol.codec.decoder import MAX_PAYLOAD
from tests.support.synthetic_motion import talking


def call(profile: Profile, frames: int, *, ack_delay: int) -> list[tuple[int, bytes]]:
    """Return the numbered payloads of a call in which everything arrives."""
    encoder, payloads = Encoder(profile), []
    for number in range(0, frames, profile.frames_per_datagram):
        if ack_delay:
            encoder.acknowledge(range(number - ack_delay + 1))
        payloads.append((number, encoder.encode(talking(profile.frames_per_datagram, first=number), number)))
    return payloads


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@given(lost=st.sets(st.integers(0, 39)), acks_lost=st.sets(st.integers(0, 39)), delay=st.integers(1, 12))
def test_no_loss_makes_a_frame_wrong(profile: Profile, lost: set[int], acks_lost: set[int], delay: int) -> None:
    """Every datagram that arrives is decoded at once, to the last bit what the encoder knows it to be."""
    encoder, decoder = Encoder(profile), Decoder()
    acknowledged: list[tuple[int, int]] = []
    for position in range(40):
        number = position * profile.frames_per_datagram
        encoder.acknowledge([n for heard, n in acknowledged if heard <= number])
        payload = encoder.encode(talking(profile.frames_per_datagram, first=number), number)
        if position in lost:
            continue
        shown = decoder.decode(payload, number)
        assert [frame.frame_number for frame in shown] == list(range(number, number + profile.frames_per_datagram))
        if position - 1 not in lost:
            for frame in shown:
                mine = encoder.decode_own(frame.frame_number)
                assert mine is not None
                assert np.array_equal(frame.pose, mine.pose)
                assert np.array_equal(frame.displacements, mine.displacements)
        if position not in acks_lost:
            acknowledged += [(number + delay, frame.frame_number) for frame in shown]


def test_a_receiver_that_joins_late_says_what_it_misses_and_recovers() -> None:
    encoder, decoder = Encoder(), Decoder()
    for number in range(20):
        encoder.encode(talking(1, first=number), number)
        encoder.acknowledge([number])
    payload = encoder.encode(talking(1, first=20), 20)
    with pytest.raises(MissingReferenceError, match="frame 19 is the reference and is not known"):
        decoder.decode(payload, 20)
    encoder.drop_references()
    assert decoder.decode(encoder.encode(talking(1, first=21), 21), 21)


def test_datagrams_may_overtake_each_other() -> None:
    payloads = call(LIVE, 30, ack_delay=6)
    in_order, shuffled = Decoder(), Decoder()
    poses = {number: in_order.decode(payload, number)[0].pose for number, payload in payloads}
    for at in range(0, 30, 2):
        for number, payload in (payloads[at + 1], payloads[at]):
            [frame] = shuffled.decode(payload, number)
            steps = (frame.pose - poses[number])[:3]
            assert np.abs(steps).max() < 0.1  # they may lean less


def test_strides_space_the_numbers() -> None:
    encoder, decoder = Encoder(), Decoder()
    payload = encoder.encode(talking(4), 8, stride=3)
    assert [frame.frame_number for frame in decoder.decode(payload, 8)] == [8, 11, 14, 17]


@given(st.binary(max_size=64), st.integers(0, 1 << 40))
def test_any_bytes_give_frames_or_protocol_error(data: bytes, number: int) -> None:
    try:
        for frame in Decoder().decode(data, number):
            assert np.isfinite(frame.displacements).all()
            assert np.isfinite(frame.pose).all()
    except ProtocolError:
        pass


@given(st.sampled_from([LIVE, NARROWBAND, RICH]), st.integers(0, 9), st.data())
def test_mutations_and_truncations_give_frames_or_protocol_error(
    profile: Profile, at: int, data: st.DataObject
) -> None:
    payloads = call(profile, 10 * profile.frames_per_datagram, ack_delay=4)
    decoder = Decoder()
    for number, payload in payloads[:at]:
        decoder.decode(payload, number)
    number, payload = payloads[at]
    mutated = bytearray(payload[: data.draw(st.integers(0, len(payload)))] + data.draw(st.binary(max_size=3)))
    if mutated:
        mutated[data.draw(st.integers(0, len(mutated) - 1))] ^= data.draw(st.integers(0, 255))
    try:
        decoder.decode(bytes(mutated), number)
    except ProtocolError:
        pass


def test_a_bad_payload_is_not_remembered() -> None:
    decoder = Decoder()
    payloads = call(LIVE, 8, ack_delay=1)
    decoder.decode(payloads[0][1], 0)
    with pytest.raises(ProtocolError):
        decoder.decode(payloads[1][1] + b"\1\2\3", 1)
    with pytest.raises(MissingReferenceError):
        decoder.decode(payloads[2][1], 2)


def test_long_payloads_are_refused_at_once() -> None:
    with pytest.raises(ProtocolError, match="payload too long"):
        Decoder().decode(b"\7" * (MAX_PAYLOAD + 1), 0)
