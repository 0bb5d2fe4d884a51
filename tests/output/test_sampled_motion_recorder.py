import numpy as np

from conf.face.head_pose import NEUTRAL_POSE
from conf.output.sampled_motion_recorder import MotionRecorder


def test_a_take_at_uneven_times_becomes_even() -> None:
    take = MotionRecorder()
    rng = np.random.default_rng(3)
    for time in np.cumsum(rng.uniform(0.005, 0.06, 60)):
        take.add(np.full((50, 3), 100 * time, np.float32), NEUTRAL_POSE, float(time))
    recording = take.finish("take")
    assert recording is not None
    steps = np.diff(recording.motion.displacements[:, 0, 0])
    np.testing.assert_allclose(steps, 100 / 30, rtol=1e-3)
    assert MotionRecorder().finish("nothing") is None
