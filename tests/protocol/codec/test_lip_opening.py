"""The opening of the mouth is measured as points move, corrected in one direction, and arrives near what was sent."""

from dataclasses import replace

import numpy as np
import pytest

from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.lip_opening import MAX_SHOWN_SHUT, NEARLY_SHUT, LipOpening
from conf.protocol.codec.model import load_models
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.reference_frames import POSE_VALUES, QuantisedFrame
from conf.protocol.messages import MotionFrame
from tests.support.synthetic_motion import talking

MODELS = load_models()
LIVE = MODELS["live"]
OPENING = LIVE.lip_opening


def opened(frame: MotionFrame, by: float) -> MotionFrame:
    """Return a frame with a mouth that is more open, eye distances, and else the same components."""
    return OPENING.correct([frame], [-by])[0]


def opening(frame: MotionFrame) -> float:
    return float(frame.displacements.reshape(-1) @ OPENING.gradient)


@pytest.mark.parametrize("name", PROFILES)
def test_the_direction_opens_the_mouth_by_the_length_asked_for(name: str) -> None:
    own = MODELS[name].lip_opening
    assert own.direction @ own.gradient == pytest.approx(1)
    components = own.direction @ MODELS[name].transform.forward_matrix
    np.testing.assert_allclose(components @ MODELS[name].transform.inverse_matrix, own.direction, rtol=1e-3, atol=0.5)


def test_errors_up_to_the_limit_are_none() -> None:
    frame = QuantisedFrame((0,) * len(LIVE.transform.stagger))
    displacements, pose = LIVE.transform.inverse(frame)
    shown = MotionFrame(0.0, displacements, pose)
    for by, expected in (
        (0.9 * OPENING.max_error, 0.0),
        (1.1 * OPENING.max_error, -1.1 * OPENING.max_error),
        (-0.03, 0.03),
    ):
        errors = OPENING.errors(LIVE.transform, [opened(shown, by)], [frame], [])
        assert errors == pytest.approx([expected], abs=1e-5)
    assert OPENING.correct([shown], [0.0])[0].displacements.tolist() == displacements.tolist()


def test_the_limit_is_0_9_mm_or_what_the_step_allows() -> None:
    assert OPENING.max_error == pytest.approx(0.0105)
    assert MODELS["rich"].lip_opening.max_error == 0.0105
    assert MODELS["slow"].lip_opening.max_error == pytest.approx(0.0165)


@pytest.mark.parametrize(("sent", "shown", "is_error"), [(0.9, 0.9, False), (0.9, 1.05, True), (1.05, 1.2, False)])
def test_a_mouth_that_is_nearly_shut_is_not_shown_open(sent: float, shown: float, is_error: bool) -> None:
    """sent, shown : openings, of NEARLY_SHUT and of MAX_SHOWN_SHUT"""
    displacements, pose = LIVE.transform.inverse(QuantisedFrame((0,) * len(LIVE.transform.stagger)))
    steps = opened(MotionFrame(0.0, displacements, pose), shown * MAX_SHOWN_SHUT).displacements
    moved = replace(LIVE.transform, inverse_matrix=LIVE.transform.inverse_matrix.copy())
    moved.inverse_matrix[0] = steps.reshape(-1)
    frame = QuantisedFrame((*(0,) * POSE_VALUES, 1, *(0,) * (len(moved.inverse_matrix) - 1)))
    source = opened(MotionFrame(0.0, displacements * 0, pose), sent * NEARLY_SHUT)
    [error] = LipOpening.build(OPENING.gradient, moved, step=LIVE.profile.step).errors(moved, [source], [frame], [])
    assert (error != 0) == is_error
    assert not is_error or error == pytest.approx(shown * MAX_SHOWN_SHUT - sent * NEARLY_SHUT, abs=1e-4)


@pytest.mark.slow
def test_far_fewer_openings_arrive_with_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a mouth that opens and shuts faster than a mouth can."""

    def count_errors() -> int:
        rng = np.random.default_rng(5)
        encoder, decoder, far = Encoder(), Decoder(), 0
        for number, frame in enumerate(talking(150)):
            source = opened(replace(frame, displacements=frame.displacements * 0), rng.uniform(0, 0.1))
            encoder.acknowledge(range(number - 1))
            [shown] = decoder.decode(encoder.encode([source], number), number)
            far += abs(float(shown.displacements.reshape(-1) @ OPENING.gradient) - opening(source)) > OPENING.max_error
        return far

    corrected = count_errors()
    monkeypatch.setattr("conf.protocol.codec.encoder.MOUTH_ATTEMPTS", 1)  # only the first is measured
    assert corrected < count_errors() / 2


def test_the_opening_is_that_of_the_points_that_are_shown() -> None:
    point = int(np.abs(OPENING.gradient).argmax()) // 3
    frame, earlier = (
        QuantisedFrame(tuple(np.random.default_rng(seed).integers(-1, 2, len(LIVE.transform.stagger)).tolist()), *rest)
        for seed, rest in ((6, (False, {point: (0, 40, 0)})), (7, ()))
    )
    shown, pose = LIVE.transform.inverse(frame, [earlier])
    source = MotionFrame(0.0, shown * 0, pose)
    expected = float(shown.reshape(-1) @ OPENING.gradient)
    assert abs(expected) > OPENING.max_error
    assert OPENING.errors(LIVE.transform, [source], [frame], [earlier]) == pytest.approx([expected], rel=1e-4)
