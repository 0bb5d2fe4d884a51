"""The sending half: cheap, true, and careful about what it predicts from."""

import numpy as np
import pytest

from conf.protocol.codec import LIVE, NARROWBAND, RICH, Decoder, Encoder
from conf.protocol.codec.model import load_models
from conf.protocol.codec.payload_header import MAX_FRAMES
from conf.protocol.messages import MotionFrame
from tests.support.synthetic_motion import grimace, still, talking


def steps_off(frame: MotionFrame, displacements: np.ndarray, pose: np.ndarray) -> float:
    """Return how far a decoded frame is from the true one, root of the summed squares, in steps of live."""
    transform = load_models()["live"].transform
    size = round(transform.log_scale(frame.pose))
    true = transform.forward(frame.displacements, frame.pose, log_scale=size)
    return float(np.linalg.norm(true - transform.forward(displacements, pose, log_scale=size)))


def test_acknowledged_frames_make_later_ones_smaller() -> None:
    sizes = {}
    for delay in (2, 8, 0):
        encoder, total = Encoder(), 0
        for number, frame in enumerate(talking(120)):
            if delay:
                encoder.acknowledge([number - delay])
            total += len(encoder.encode([frame], number))
        sizes[delay] = total
    assert sizes[2] < sizes[8] < sizes[0]


def test_a_still_face_costs_a_byte() -> None:
    encoder = Encoder()
    payloads = []
    for number, frame in enumerate(still(30)):
        encoder.acknowledge([number - 2])
        payloads.append(encoder.encode([frame], number))
    assert max(map(len, payloads[10:])) <= 1


def test_only_a_visible_change_is_a_change() -> None:
    encoder = Encoder()
    first, *_ = still(1)
    assert encoder.differs_visibly(first)
    encoder.encode([first], 0)
    assert not encoder.differs_visibly(first)
    assert not encoder.differs_visibly(MotionFrame(1.0, first.displacements + 1, first.pose))
    assert encoder.differs_visibly(talking(1)[0])
    assert encoder.differs_visibly(MotionFrame(1.0, first.displacements, first.pose * 1.5))


def test_what_was_never_sent_is_not_acknowledged() -> None:
    """An acknowledgement of a number to come must not count when the number comes."""
    encoder, decoder = Encoder(), Decoder()
    frames = talking(3)
    encoder.acknowledge([0, 1, 2])
    for number, frame in enumerate(frames):
        payload = encoder.encode([frame], number)
    decoder.decode(payload, 2)  # has seen nothing before


def test_forgetting_makes_the_next_payload_stand_alone() -> None:
    encoder = Encoder()
    for number, frame in enumerate(talking(10)):
        encoder.encode([frame], number)
        encoder.acknowledge([number])
    encoder.drop_references()
    Decoder().decode(encoder.encode(talking(1), 10), 10)


def test_a_new_profile_starts_without_references_and_with_its_own_numbers() -> None:
    encoder, decoder = Encoder(RICH), Decoder()
    for number in range(0, 40, 2):
        decoder.decode(encoder.encode(talking(2, first=number), number), number)
        encoder.acknowledge([number, number + 1])
    encoder.profile = LIVE
    Decoder().decode(encoder.encode(talking(1), 20), 20)
    encoder.acknowledge([20])
    encoder.profile = NARROWBAND
    Decoder().decode(encoder.encode(talking(3), 21), 21)


def test_a_grimace_is_carried_within_the_budget() -> None:
    """Points that no trained face has moved like that arrive a few at a time, and stay."""
    encoder, decoder = Encoder(), Decoder()
    transform = load_models()["live"].transform
    off, sizes = [], []
    for number, frame in enumerate(grimace(30)):
        encoder.acknowledge([number - 2])
        payload = encoder.encode([frame], number)
        [shown] = decoder.decode(payload, number)
        left = (frame.displacements - shown.displacements) / transform.residual_steps
        off.append(float(np.linalg.norm(left, axis=1).max()))
        sizes.append(len(payload))
    assert off[0] > 5
    assert max(off[20:]) < 4
    assert max(sizes) <= LIVE.target_bits / 8 + 4
    assert np.mean(sizes) < 6


def test_frames_are_true_within_steps() -> None:
    encoder, decoder = Encoder(), Decoder()
    off = []
    for number, frame in enumerate(talking(60)):
        encoder.acknowledge([number - 2])
        [shown] = decoder.decode(encoder.encode([frame], number), number)
        off.append(steps_off(frame, shown.displacements, shown.pose))
    assert np.mean(off) < 0.35 * np.sqrt(26)


def test_wrong_arguments_are_named() -> None:
    encoder = Encoder()
    frames = talking(MAX_FRAMES + 1)
    with pytest.raises(ValueError, match="a payload has 1 to 8 frames, not 9"):
        encoder.encode(frames, 0)
    with pytest.raises(ValueError, match="stride must be 1 to 4, not 5"):
        encoder.encode(frames[:1], 0, stride=5)
    encoder.encode(frames[:1], 5)
    with pytest.raises(ValueError, match="frame_number 5 is not greater than 5"):
        encoder.encode(frames[:1], 5)
    bad = MotionFrame(0.0, np.full((50, 3), np.nan, np.float32), frames[0].pose)
    with pytest.raises(ValueError, match="not finite, or a value of its pose is 50 or more"):
        encoder.encode([bad], 6)


def test_extreme_motion_is_clipped_not_refused() -> None:
    wild = MotionFrame(0.0, np.full((50, 3), 1e30, np.float32), np.array([49.0, -49, 49, -49, 49, -49]))
    encoder, decoder = Encoder(), Decoder()
    for number in range(3):
        [shown] = decoder.decode(encoder.encode([wild], number), number)
        encoder.acknowledge([number])
        assert np.isfinite(shown.displacements).all()
        assert np.isfinite(shown.pose).all()


def test_reconstruct_is_what_a_receiver_shows() -> None:
    encoder, decoder = Encoder(), Decoder()
    for number, frame in enumerate(talking(5)):
        [shown] = decoder.decode(encoder.encode([frame], number), number)
        mine = encoder.decode_own(number)
        assert mine is not None
        assert np.array_equal(mine.displacements, shown.displacements)
        assert np.array_equal(mine.pose, shown.pose)
    assert encoder.decode_own(77) is None
