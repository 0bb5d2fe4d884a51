"""The width of the mouth is that of the lips' outer corners, and arrives near what was sent."""

from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_INDEX
from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.encoder import Encoder
from conf.protocol.codec.model import load_models
from conf.protocol.codec.mouth_width import CORNERS, EYE_DISTANCES_PER_UNIT, MouthWidth
from conf.sender.motion.mean_face import MEAN_FACE
from tests.support.synthetic_motion import talking

MODELS = load_models()
LIVE = MODELS["live"]
WIDTH = MouthWidth.build(LIVE.transform, step=LIVE.profile.step)


def test_the_corners_and_the_unit_are_those_of_the_mean_face() -> None:
    assert CORNERS == tuple(CONTROL_POINT_INDEX[f"outer_lip_corner_{side}"] for side in "lr")
    width, eyes = (
        np.linalg.norm(MEAN_FACE[CONTROL_POINT_INDEX[f"{name}_l"]] - MEAN_FACE[CONTROL_POINT_INDEX[f"{name}_r"]])
        for name in ("outer_lip_corner", "eye_outer_corner")
    )
    assert EYE_DISTANCES_PER_UNIT == pytest.approx(width / 1024 / eyes, rel=1e-3)


def test_the_gradient_is_of_both_corners_sideways() -> None:
    gradient = WIDTH.gradient.reshape(-1, 3)
    expected = np.zeros_like(gradient)
    expected[CORNERS[0], 0], expected[CORNERS[1], 0] = EYE_DISTANCES_PER_UNIT, -EYE_DISTANCES_PER_UNIT
    assert np.array_equal(gradient, expected)


def test_the_limit_is_0_7_mm_or_what_the_step_allows() -> None:
    assert WIDTH.max_error == pytest.approx(0.00846)
    assert MouthWidth.build(LIVE.transform, step=0.005).max_error == 0.008


def test_only_payloads_of_one_frame_are_corrected() -> None:
    assert {name for name, model in MODELS.items() if model.mouth_width} == {"live", "voice"}


@pytest.mark.slow
def test_far_fewer_widths_arrive_with_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def count_errors() -> int:
        rng = np.random.default_rng(5)
        encoder, decoder, far = Encoder(), Decoder(), 0
        for number, frame in enumerate(talking(150)):
            [source] = WIDTH.correct([replace(frame, displacements=frame.displacements * 0)], [rng.uniform(0, 0.1)])
            encoder.acknowledge(range(number - 1))
            [shown] = decoder.decode(encoder.encode([source], number), number)
            sent, received = (float(f.displacements.reshape(-1) @ WIDTH.gradient) for f in (source, shown))
            far += WIDTH.is_too_far(sent, received)
        return far

    corrected = count_errors()
    monkeypatch.setattr("conf.protocol.codec.encoder.MOUTH_ATTEMPTS", 1)  # only the first is measured
    assert corrected < count_errors() / 2
