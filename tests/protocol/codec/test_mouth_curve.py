"""A length of the mouth is measured on what is shown and corrected in one direction; both lengths share this."""

from dataclasses import replace

import numpy as np
import pytest

from conf.protocol.codec.model import load_models
from conf.protocol.codec.mouth_curve import MouthCurve, by_component_and_direction
from conf.protocol.codec.mouth_width import MouthWidth
from conf.protocol.codec.profiles import PROFILES
from conf.protocol.codec.reference_frames import QuantisedFrame
from conf.protocol.messages import MotionFrame

MODELS = load_models()
LIVE = MODELS["live"]
CURVES = {"opening": LIVE.lip_opening, "width": MouthWidth.build(LIVE.transform, step=LIVE.profile.step)}


def shown(seed: int) -> tuple[MotionFrame, QuantisedFrame]:
    values = np.random.default_rng(seed).integers(-3, 4, len(LIVE.transform.stagger)).tolist()
    frame = QuantisedFrame(tuple(values))
    return MotionFrame(0.0, *LIVE.transform.inverse(frame)), frame


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("by", [-0.05, -0.02, 0.02, 0.05])
def test_a_target_corrected_by_its_error_has_none(curve: MouthCurve, by: float) -> None:
    motion, frame = shown(1)
    [target] = curve.correct([motion], [by])
    errors = curve.errors(LIVE.transform, [target], [frame], [])
    assert errors == pytest.approx([by], abs=1e-4)
    [back] = curve.correct([target], [-by])
    assert curve.errors(LIVE.transform, [back], [frame], []) == [0.0]


@pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)
def test_no_other_change_of_the_components_is_as_small(curve: MouthCurve) -> None:
    components = curve.direction @ LIVE.transform.forward_matrix
    for seed in range(5):
        other = np.random.default_rng(seed).normal(0, 1, len(components))
        other /= other @ curve.by_component  # changes the length by as much
        assert np.linalg.norm(components) <= np.linalg.norm(other) * (1 + 1e-3)


def test_the_frames_before_count_in_a_payload_of_several() -> None:
    curve = replace(CURVES["width"], max_error=0.0)
    pairs = [shown(seed) for seed in (2, 3, 4)]
    frames, coded = [motion for motion, _ in pairs], [frame for _, frame in pairs]
    together = curve.errors(LIVE.transform, frames, coded, [])
    for position in range(3):
        earlier = coded[:position][::-1]
        assert together[position : position + 1] == pytest.approx(
            curve.errors(LIVE.transform, frames[position : position + 1], coded[position : position + 1], earlier)
        )


@pytest.mark.parametrize("name", PROFILES)
def test_the_direction_changes_the_length_by_one(name: str) -> None:
    for curve in CURVES.values():
        by_component, direction = by_component_and_direction(curve.gradient, MODELS[name].transform)
        assert direction @ curve.gradient == pytest.approx(1)
        assert np.allclose(by_component, MODELS[name].transform.inverse_matrix @ curve.gradient)
