import numpy as np
import pytest

from conf.face.action_units import load_emotions
from conf.face.performance import Envelope
from conf.protocol.messages import MotionFrame
from conf.receiver.feelings import Feelings

ENVELOPE = Envelope()
MOTION = np.full((50, 3), 20.0, np.float32)
FRAME = MotionFrame(0.0, MOTION, np.zeros(6))


def test_an_emotion_comes_over_the_motion_and_goes() -> None:
    feelings = Feelings()
    assert feelings.over(FRAME, 0.0) is FRAME
    assert feelings.play(1, 1.0) == "joy"
    np.testing.assert_array_equal(feelings.over(FRAME, 1.0).displacements, MOTION)
    full = feelings.over(FRAME, 1.0 + ENVELOPE.onset + 0.1)
    difference = full.displacements - MOTION
    assert np.abs(difference - load_emotions()["joy"])[:, [0, 2]].max() < 1e-3, "lids may meet, upright"
    assert full.pose is FRAME.pose
    assert feelings.over(FRAME, 1.0 + ENVELOPE.duration + 0.1) is FRAME


def test_the_next_one_takes_over() -> None:
    feelings = Feelings()
    feelings.play(1, 0.0)
    names = load_emotions().names
    assert feelings.play(len(names), 1.0) == names[-1]
    both = feelings.over(FRAME, 1.05).displacements
    later = feelings.over(FRAME, 1.0 + ENVELOPE.release + 0.1).displacements
    assert np.abs(later - MOTION - load_emotions()[names[-1]])[:, 0].max() < 1e-3
    assert np.abs(both - later).max() > 50


@pytest.mark.parametrize("number", range(1, 7))
def test_every_key_has_an_emotion(number: int) -> None:
    assert Feelings().play(number, 0.0) in load_emotions().names
