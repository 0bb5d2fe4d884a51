"""The decoder: after losses, delays and forged payloads a frame is correct or an error."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ProtocolError
from conf.protocol.codec.decoder import MAX_PAYLOAD, Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.profiles import LIVE, NARROWBAND, PROFILES, RICH, Profile
from conf.protocol.codec.reference_frames import MissingReferenceError
from tests.protocol.independent_decoder import PayloadReader
from tests.support.synthetic_motion import grimace, talking

PAYLOADS = 14


def call(profile: Profile, frames: int, *, ack_delay: int) -> list[tuple[int, bytes]]:
    """Return the numbered payloads of a call without losses."""
    encoder, payloads = Encoder(profile), []
    for number in range(0, frames, profile.frames_per_datagram):
        if ack_delay:
            encoder.acknowledge(range(number - ack_delay + 1))
        payloads.append((number, encoder.encode(talking(profile.frames_per_datagram, first=number), number)))
    return payloads


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@given(
    lost=st.sets(st.integers(0, PAYLOADS - 1)), acks_lost=st.sets(st.integers(0, PAYLOADS - 1)), delay=st.integers(1, 8)
)
def test_no_loss_makes_a_frame_wrong(profile: Profile, lost: set[int], acks_lost: set[int], delay: int) -> None:
    """Every payload that arrives is decoded at once, bit for bit as the encoder expects."""
    encoder, decoder = Encoder(profile), Decoder()
    acknowledged: list[tuple[int, int]] = []
    for position in range(PAYLOADS):
        number = position * profile.frames_per_datagram
        encoder.acknowledge([n for received, n in acknowledged if received <= number])
        payload = encoder.encode(talking(profile.frames_per_datagram, first=number), number)
        if position in lost:
            continue
        decoded = decoder.decode(payload, number)
        assert [frame.frame_number for frame in decoded] == list(range(number, number + profile.frames_per_datagram))
        if lost.isdisjoint({position - 1, position - 2}):
            for frame in decoded:
                own = encoder.decode_own(frame.frame_number)
                assert own is not None
                assert np.array_equal(frame.pose, own.pose)
                assert np.array_equal(frame.displacements, own.displacements)
        if position not in acks_lost:
            acknowledged += [(number + delay, frame.frame_number) for frame in decoded]


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@pytest.mark.parametrize("stride", [1, 3])
def test_frames_are_those_of_the_independent_decoder(profile: Profile, stride: int) -> None:
    encoder, decoder, reader = Encoder(profile), Decoder(), PayloadReader()
    count = profile.frames_per_datagram
    frames = talking(8 * count) + grimace(4 * count)
    for position in range(12):
        number = 5 + position * count * stride
        encoder.acknowledge(range(number - count * stride))
        payload = encoder.encode(frames[position * count : (position + 1) * count], number, stride=stride)
        decoded = decoder.decode(payload, number)
        assert reader.read(payload, number) == (profile.name, stride, [frame.frame_number for frame in decoded])
        for frame in decoded:
            displacements, pose = reader.motion(profile.name, frame.frame_number, stride)
            np.testing.assert_allclose(frame.displacements, displacements, rtol=1e-6, atol=1e-3)
            np.testing.assert_allclose(frame.pose, pose, rtol=1e-9, atol=1e-12)


def test_a_receiver_that_joins_late_reports_the_missing_reference_and_recovers() -> None:
    encoder, decoder = Encoder(), Decoder()
    for number in range(20):
        encoder.encode(talking(1, first=number), number)
        encoder.acknowledge([number])
    payload = encoder.encode(talking(1, first=20), 20)
    with pytest.raises(MissingReferenceError, match="frame 19 is the reference and is not known"):
        decoder.decode(payload, 20)
    encoder.drop_references()
    assert decoder.decode(encoder.encode(talking(1, first=21), 21), 21)


def test_payloads_may_arrive_out_of_order() -> None:
    payloads = call(LIVE, 30, ack_delay=6)
    in_order, shuffled = Decoder(), Decoder()
    poses = {number: in_order.decode(payload, number)[0].pose for number, payload in payloads}
    for start in range(0, 30, 2):
        for number, payload in (payloads[start + 1], payloads[start]):
            [frame] = shuffled.decode(payload, number)
            difference = (frame.pose - poses[number])[:3]
            assert np.abs(difference).max() < 0.1  # the reconstruction shift may be missing


def test_profiles_have_separate_references() -> None:
    decoder = Decoder()
    for number, payload in call(LIVE, 3, ack_delay=1):
        decoder.decode(payload, number)
    [*_, (number, payload)] = call(RICH, 6, ack_delay=1)
    with pytest.raises(MissingReferenceError):
        decoder.decode(payload, number)


@given(st.binary(max_size=64), st.integers(0, 1 << 40))
def test_any_bytes_give_frames_or_protocol_error(data: bytes, number: int) -> None:
    try:
        for frame in Decoder().decode(data, number):
            assert np.isfinite(frame.displacements).all()
            assert np.isfinite(frame.pose).all()
    except ProtocolError:
        pass


CALLS = {
    profile.name: call(profile, 10 * profile.frames_per_datagram, ack_delay=4) for profile in (LIVE, NARROWBAND, RICH)
}


@pytest.mark.slow
@given(st.sampled_from(sorted(CALLS)), st.integers(0, 9), st.data())
def test_mutations_and_truncations_give_frames_or_protocol_error(
    profile: str, position: int, data: st.DataObject
) -> None:
    decoder = Decoder()
    for number, payload in CALLS[profile][:position]:
        decoder.decode(payload, number)
    number, payload = CALLS[profile][position]
    mutated = bytearray(payload[: data.draw(st.integers(0, len(payload)))] + data.draw(st.binary(max_size=3)))
    if mutated:
        mutated[data.draw(st.integers(0, len(mutated) - 1))] ^= data.draw(st.integers(0, 255))
    try:
        decoder.decode(bytes(mutated), number)
    except ProtocolError:
        pass


def test_an_invalid_payload_is_not_stored() -> None:
    decoder = Decoder()
    payloads = call(LIVE, 8, ack_delay=1)
    decoder.decode(payloads[0][1], 0)
    with pytest.raises(ProtocolError):
        decoder.decode(payloads[1][1] + b"\1\2\3", 1)
    with pytest.raises(MissingReferenceError):
        decoder.decode(payloads[2][1], 2)


def test_long_payloads_are_rejected_at_once() -> None:
    assert MAX_PAYLOAD == 1100
    with pytest.raises(ProtocolError, match="payload too long"):
        Decoder().decode(b"\7" * (MAX_PAYLOAD + 1), 0)
    with pytest.raises(ProtocolError, match="cut short or padded"):
        Decoder().decode(b"\7" * MAX_PAYLOAD, 0)


def test_other_models_can_be_given() -> None:
    with pytest.raises(KeyError):
        Decoder(models={}).decode(call(LIVE, 1, ack_delay=0)[0][1], 0)
