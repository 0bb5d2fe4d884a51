import numpy as np
import pytest

from conf.face.animation.action_units import load_emotions
from conf.face.animation.timed_expression import Envelope, blend_without_doubling
from conf.protocol.messages import MotionFrame
from conf.receiver.expression_overlay import ExpressionOverlay

ENVELOPE = Envelope()
MOTION = np.random.default_rng(1).normal(0.0, 20.0, (50, 3)).astype(np.float32)
FRAME = MotionFrame(0.0, MOTION, np.zeros(6))


def test_an_emotion_is_added_to_the_motion_and_ends() -> None:
    overlay = ExpressionOverlay()
    assert overlay.apply(FRAME, 0.0) is FRAME
    assert overlay.play(1, 1.0) == "joy"
    np.testing.assert_array_equal(overlay.apply(FRAME, 1.0).displacements, MOTION)
    full = overlay.apply(FRAME, 1.0 + ENVELOPE.onset + 0.1)
    np.testing.assert_allclose(full.displacements, blend_without_doubling(MOTION, load_emotions()["joy"]), atol=1e-3)
    assert full.pose is FRAME.pose
    assert overlay.apply(FRAME, 1.0 + ENVELOPE.duration + 0.1) is FRAME


def test_the_next_emotion_fades_out_the_last() -> None:
    overlay = ExpressionOverlay()
    overlay.play(1, 0.0)
    names = load_emotions().names
    assert overlay.play(len(names), 1.0) == names[-1]
    both = overlay.apply(FRAME, 1.05).displacements
    later = overlay.apply(FRAME, 1.0 + ENVELOPE.release + 0.1).displacements
    np.testing.assert_allclose(later, blend_without_doubling(MOTION, load_emotions()[names[-1]]), atol=1e-3)
    assert np.abs(both - later).max() > 50


@pytest.mark.parametrize("number", range(1, 7))
def test_every_number_key_has_an_emotion(number: int) -> None:
    assert ExpressionOverlay().play(number, 0.0) in load_emotions().names
