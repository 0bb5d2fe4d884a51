import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conf.errors import ProtocolError
from conf.protocol.fixed_point import POSE_STEPS, decode_motion, encode_motion


@given(
    arrays(np.float32, (50, 3), elements=st.floats(-30000, 30000, width=32)),
    arrays(float, 6, elements=st.floats(-3, 3)),
)
def test_no_number_is_off_by_more_than_half_a_step(displacements: np.ndarray, pose: np.ndarray) -> None:
    data = encode_motion(displacements, pose)
    assert len(data) == 312
    back, back_pose = decode_motion(data, 50)
    assert np.abs(back - displacements).max() <= 0.5
    assert (np.abs(back_pose - pose) <= POSE_STEPS * 0.5 + 1e-12).all()


def test_the_wrong_length_is_refused() -> None:
    with pytest.raises(ProtocolError, match="motion of 311 bytes does not carry 50 points"):
        decode_motion(bytes(311), 50)
