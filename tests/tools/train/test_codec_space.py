"""The learned space: the curves of the expression weigh more than points alone, and synthesis inverts analysis."""

from dataclasses import replace

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.protocol.messages import MotionFrame
from tests.support.synthetic_motion import TYPICAL_POSE
from tools.bench.expression_curves import GRADIENTS, NAMES
from tools.bench.tracks import Track
from tools.train.codec_space import SPACE, fit_shared, fit_space


@pytest.fixture(scope="module")
def tracks() -> list[Track]:
    """Return one track of random motion in every direction."""
    rng = np.random.default_rng(2)
    motion = rng.normal(0, 60, (200, CONTROL_POINT_COUNT, 3)).astype(np.float32)
    frames = [MotionFrame(number / 15, displacements, TYPICAL_POSE) for number, displacements in enumerate(motion)]
    return [Track("random", frames, np.full(len(frames), 0.2), Fapu(6, 6, 6, 6, 6))]


def test_synthesis_inverts_analysis(tracks: list[Track]) -> None:
    arrays = fit_space(SPACE, tracks)
    np.testing.assert_allclose(arrays["synthesis"] @ arrays["analysis"], np.eye(SPACE.components), atol=1e-5)
    assert len(arrays["stagger"]) == 6 + SPACE.components


def test_a_step_along_a_curve_is_shorter_where_curves_are_measured(tracks: list[Track]) -> None:
    """The length in the space of a displacement along the gradient is the number of steps that it takes."""
    gradient = GRADIENTS[NAMES.index("brow_knit")].reshape(-1)
    length = [
        np.linalg.norm(gradient @ fit_space(replace(SPACE, components=150, curve_weight=weight), tracks)["analysis"])
        for weight in (SPACE.curve_weight, 0.0)
    ]
    assert length[0] > 2 * length[1]


def test_the_step_of_the_pose_is_as_asked(tracks: list[Track]) -> None:
    fine, coarse = (fit_space(replace(SPACE, pose_step=step), tracks)["pose_unit"] for step in (0.5, 1.0))
    np.testing.assert_allclose(2 * fine, coarse, rtol=1e-6)


def test_all_profiles_share_the_typical_face(tracks: list[Track]) -> None:
    shared = fit_shared(tracks)
    assert float(shared["usual_log_scale"]) == pytest.approx(TYPICAL_POSE[5])
    assert shared["correction"].shape == (CONTROL_POINT_COUNT, 3) and (shared["correction"] > 0).all()
