"""The encoder: small payloads, bounded errors, prediction only from acknowledged frames."""

import hashlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder, code_frame
from conf.protocol.codec.model import load_models
from conf.protocol.codec.payload_header import MAX_FRAMES, PayloadHeader, code_header
from conf.protocol.codec.profiles import LIVE, NARROWBAND, PROFILES, RICH
from conf.protocol.codec.reference_frames import POSE_VALUES, QuantisedFrame
from conf.protocol.codec.symbol_coder import SymbolReader, SymbolWriter
from conf.protocol.codec.syntax import Context
from conf.protocol.messages import MotionFrame
from tests.support.synthetic_motion import grimace, still, talking

MODEL = load_models()["live"]
TRANSFORM = MODEL.transform


def header_of(payload: bytes) -> PayloadHeader:
    """Return the header of a payload."""
    return code_header(SymbolReader(payload))


def error_in_steps(frame: MotionFrame, displacements: np.ndarray, pose: np.ndarray) -> float:
    """Return the distance of a decoded frame from the true one, root of the summed squares, in steps of live."""
    size = round(TRANSFORM.log_scale(frame.pose))
    true = TRANSFORM.forward(frame.displacements, frame.pose, log_scale=size)
    return float(np.linalg.norm(true - TRANSFORM.forward(displacements, pose, log_scale=size)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("profile", "motion", "ack_delay", "digest"),
    [
        ("live", talking, 2, "d0db37e1a04076b0"),
        ("live", talking, 0, "6838515d4a634907"),
        ("live", grimace, 2, "2fe697177ba3b41b"),
        ("live", grimace, 0, "1bfe22e742ef00bd"),
        ("rich", talking, 3, "eaa9a941d5cd9108"),
        ("narrow", talking, 0, "fa43ba0bf9e6d80a"),
        ("narrow", grimace, 1, "12b7cbbee426cc6f"),
    ],
)
def test_payloads_do_not_change(
    profile: str, motion: Callable[[int], list[MotionFrame]], ack_delay: int, digest: str
) -> None:
    """Settings of the encoder that change no syntax show here. ack_delay : payloads, 0 for no acknowledgements"""
    count = PROFILES[profile].frames_per_datagram
    encoder, frames, payloads = Encoder(PROFILES[profile]), motion(36), []
    for number in range(0, 36, count):
        if ack_delay:
            encoder.acknowledge(range(number - (ack_delay - 1) * count))
        payloads.append(encoder.encode(frames[number : number + count], number))
    assert hashlib.sha256(b"|".join(payloads)).hexdigest()[:16] == digest


@pytest.mark.slow
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


@pytest.mark.parametrize(("number", "age"), [(1, 1), (2, 2), (63, 63), (64, 0)])
def test_the_reference_is_at_most_63_ticks_old(number: int, age: int) -> None:
    encoder = Encoder()
    encoder.encode(talking(1), 0)
    encoder.acknowledge([0])
    assert header_of(encoder.encode(talking(1), number)) == PayloadHeader("live", 1, 1, age, second_reference=False)


@pytest.mark.parametrize(
    ("acknowledged", "stride", "age", "second_reference"),
    [([4, 5], 1, 1, True), ([3, 5], 1, 1, False), ([3, 5], 2, 1, True), ([3], 1, 3, False), ([2, 3, 9], 1, 3, True)],
)
def test_the_second_reference_is_one_stride_before_the_reference(
    acknowledged: list[int], stride: int, age: int, second_reference: bool
) -> None:
    encoder = Encoder()
    for number in range(6):
        encoder.encode(talking(1), number)
    encoder.acknowledge(acknowledged)
    header = header_of(encoder.encode(talking(2), 6, stride=stride))
    assert header == PayloadHeader("live", 2, stride, age, second_reference)


def test_frames_of_a_payload_are_stored_one_stride_apart() -> None:
    encoder = Encoder()
    encoder.encode(talking(3), 10, stride=4)
    assert [number for number in range(30) if encoder.decode_own(number)] == [10, 14, 18]
    encoder.acknowledge([18])
    assert header_of(encoder.encode(talking(1), 20)).age == 2


def test_only_a_visible_change_is_a_change() -> None:
    encoder = Encoder()
    first, *_ = still(1)
    assert encoder.differs_visibly(first)
    encoder.encode([first], 0)
    assert not encoder.differs_visibly(first)
    assert not encoder.differs_visibly(MotionFrame(1.0, first.displacements + 1, first.pose))
    assert encoder.differs_visibly(talking(1)[0])
    assert encoder.differs_visibly(MotionFrame(1.0, first.displacements, first.pose * 1.5))
    assert encoder.differs_visibly(grimace(1)[0])


@pytest.mark.parametrize(("pose_value", "step"), [(0, 1), (1, 2), (2, 3), (5, 0)])
def test_a_change_of_more_than_a_step_is_visible(pose_value: int, step: int) -> None:
    encoder = Encoder()
    encoder.encode(still(1), 0)
    shown = encoder.decode_own(0)
    assert shown is not None
    for change, visible in ((0.0, False), (1.12, False), (1.18, True), (-1.12, False), (-1.18, True)):
        pose = shown.pose.copy()
        pose[pose_value] += change * TRANSFORM.pose_steps[step]
        # The position that leaves the face centre, in face sizes, where it is.
        centre = shown.pose[3:5] / np.exp(shown.pose[5]) + TRANSFORM._rotated_centre(shown.pose[:3])
        pose[3:5] = np.exp(pose[5]) * (centre - TRANSFORM._rotated_centre(pose[:3]))
        assert encoder.differs_visibly(MotionFrame(1.0, shown.displacements, pose)) == visible, change


@pytest.mark.parametrize("staggered", [False, True])
def test_a_frame_is_coded_to_the_nearest_values(staggered: bool) -> None:
    [frame] = talking(1, first=5)
    frame = replace(frame, pose=frame.pose + np.array([0.003, 0.004, 0.002, 0.0001, 0.0002, 0.001]))
    reference = replace(MODEL.default_reference, staggered=staggered)
    coded, error = code_frame(SymbolWriter(rd_lambda=0.0), MODEL, Context(0, reference), frame)
    exact = TRANSFORM.forward(frame.displacements, frame.pose, log_scale=coded.values[0])
    difference = exact - TRANSFORM.dequantise(coded)
    difference[POSE_VALUES:] += difference[:POSE_VALUES] @ TRANSFORM.coupling
    assert coded.staggered == staggered
    assert np.abs(difference).max() <= 0.5 + 1e-9
    assert error == pytest.approx(difference @ difference)
    assert error > 0.1


def code_log_scale(value: float, reference: int) -> int:
    """Return the coded log scale of a frame whose log scale is `value` steps from the typical one."""
    # Smaller steps, so that a large value is no absurd pose.
    steps = TRANSFORM.pose_steps * [1e-3, 1, 1, 1, 1, 1]
    transform = replace(TRANSFORM, pose_steps=steps)
    [frame] = still(1)
    pose = np.array([*frame.pose[:5], TRANSFORM.typical_log_scale + value * steps[0]])
    context = Context(0, QuantisedFrame((reference, *MODEL.default_reference.values[1:])))
    model = replace(MODEL, transform=transform)
    return code_frame(SymbolWriter(rd_lambda=0.0), model, context, replace(frame, pose=pose))[0].values[0]


@pytest.mark.parametrize(
    ("value", "coded"), [(7, 7), (7.69, 7), (6.31, 7), (7.71, 8), (6.29, 6), (12.4, 12), (8191.2, 8191), (8199, 8191)]
)
def test_the_log_scale_keeps_the_value_of_a_near_reference(value: float, coded: int) -> None:
    assert code_log_scale(value, reference=7) == coded
    assert code_log_scale(-value, reference=-7) == -coded


def test_unsent_frames_are_not_acknowledged() -> None:
    """An acknowledgement of a future number must not count when a frame gets this number."""
    encoder, decoder = Encoder(), Decoder()
    encoder.acknowledge([0, 1, 2])
    for number, frame in enumerate(talking(3)):
        payload = encoder.encode([frame], number)
    decoder.decode(payload, 2)  # has decoded nothing before


def test_after_dropping_references_the_next_payload_needs_none() -> None:
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
    assert encoder.differs_visibly(talking(1)[0])
    Decoder().decode(encoder.encode(talking(1), 20), 20)
    encoder.acknowledge([20])
    encoder.profile = LIVE
    assert header_of(encoder.encode(talking(1), 21)).age == 1
    encoder.profile = NARROWBAND
    Decoder().decode(encoder.encode(talking(3), 21), 21)


def test_other_models_can_be_given() -> None:
    encoder = Encoder(LIVE, models={"live": replace(MODEL, default_reference=QuantisedFrame((5,) * 36))})
    assert encoder.encode(still(1), 0) != Encoder().encode(still(1), 0)


def test_a_grimace_is_sent_within_the_budget() -> None:
    """Points outside the trained space are sent a few at a time, and stay."""
    encoder, decoder = Encoder(), Decoder()
    errors, sizes = [], []
    for number, frame in enumerate(grimace(30)):
        encoder.acknowledge([number - 2])
        payload = encoder.encode([frame], number)
        [shown] = decoder.decode(payload, number)
        remaining = (frame.displacements - shown.displacements) / TRANSFORM.residual_steps
        errors.append(float(np.linalg.norm(remaining, axis=1).max()))
        sizes.append(len(payload))
    assert errors[0] > 5
    assert max(errors[20:]) < 4
    assert max(sizes) <= LIVE.target_bits / 8 + 4
    assert np.mean(sizes) < 6


def test_errors_are_below_the_step() -> None:
    encoder, decoder = Encoder(), Decoder()
    errors = []
    for number, frame in enumerate(talking(60)):
        encoder.acknowledge([number - 2])
        [shown] = decoder.decode(encoder.encode([frame], number), number)
        errors.append(error_in_steps(frame, shown.displacements, shown.pose))
    assert np.mean(errors) < 0.35 * np.sqrt(26)


def test_invalid_arguments_are_named() -> None:
    encoder = Encoder()
    frames = talking(MAX_FRAMES + 1)
    for wrong in (frames, []):
        with pytest.raises(ValueError, match=f"a payload has 1 to 8 frames, not {len(wrong)}"):
            encoder.encode(wrong, 0)
    for stride in (0, 5):
        with pytest.raises(ValueError, match=f"stride must be 1 to 4, not {stride}"):
            encoder.encode(frames[:1], 0, stride=stride)
    encoder.encode(frames[:8], 0, stride=4)
    with pytest.raises(ValueError, match="frame_number 28 is not greater than 28"):
        encoder.encode(frames[:1], 28)
    pose = frames[0].pose
    nan = np.full((50, 3), np.nan, np.float32)
    for bad in (MotionFrame(0.0, nan, pose), replace(frames[0], pose=np.array([0, 0, 0, 0, 0, -50.0]))):
        with pytest.raises(ValueError, match="not finite, or a value of its pose is 50 or more"):
            encoder.encode([bad], 29)


def test_extreme_motion_is_clipped() -> None:
    wild = MotionFrame(0.0, np.full((50, 3), 1e30, np.float32), np.array([49.0, -49, 49, -49, 49, -49]))
    encoder, decoder = Encoder(), Decoder()
    for number in range(3):
        [shown] = decoder.decode(encoder.encode([wild], number), number)
        encoder.acknowledge([number])
        assert np.isfinite(shown.displacements).all()
        assert np.isfinite(shown.pose).all()


def test_decode_own_returns_what_a_receiver_decodes() -> None:
    encoder, decoder = Encoder(), Decoder()
    for number, frame in enumerate(talking(5)):
        [shown] = decoder.decode(encoder.encode([frame], 3 * number), 3 * number)
        own = encoder.decode_own(3 * number)
        assert own is not None and own.frame_number == shown.frame_number
        assert np.array_equal(own.displacements, shown.displacements)
        assert np.array_equal(own.pose, shown.pose)
    assert encoder.decode_own(77) is None
    encoder.encode(talking(1, first=5), 13)
    [default, shifted, plain] = [
        encoder.decode_own(13),
        encoder.decode_own(13, stride=1),
        encoder.decode_own(13, stride=2),
    ]
    assert default is not None and shifted is not None and plain is not None
    assert np.array_equal(default.displacements, shifted.displacements)
    assert not np.array_equal(plain.displacements, shifted.displacements)


def test_small_residuals_need_a_reference() -> None:
    """3.2 steps are above the threshold with a reference, 2.5, and below that without, 4."""
    [frame], [odd] = still(1), grimace(1)
    largest = np.linalg.norm(TRANSFORM.residual(odd.displacements), axis=1).max()
    frame = replace(frame, displacements=(odd.displacements * (3.2 / largest)).astype(np.float32))
    encoder, decoder = Encoder(), Decoder()
    for number in range(2):
        decoder.decode(encoder.encode([frame], number), number)
        encoder.acknowledge([number])
    assert [bool(decoder._references["live"].require(number).residuals) for number in range(2)] == [False, True]


def test_a_payload_that_is_too_long_gives_up_precision() -> None:
    frames = talking(6)
    free = Encoder(PROFILES["slow"]).encode(frames, 0)
    assert Encoder(PROFILES["slow"]).encode(frames, 0, max_bytes=len(free)) == free
    short = Encoder(PROFILES["slow"]).encode(frames, 0, max_bytes=len(free) - 1)
    shortest = Encoder(PROFILES["slow"]).encode(frames, 0, max_bytes=1)
    assert len(shortest) <= len(short) < len(free)
    for payload in (short, shortest):
        decoded = Decoder().decode(payload, 0)
        assert len(decoded) == 6
        assert np.abs(decoded[-1].pose[:3] - frames[-1].pose[:3]).max() < 0.2
