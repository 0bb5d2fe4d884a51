"""The learned spaces: a curve of the expression weighs more in "expressions", and synthesis inverts analysis."""

import numpy as np
import pytest

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.protocol.messages import MotionFrame
from tests.support.synthetic_motion import TYPICAL_POSE
from tools.bench.expression_curves import GRADIENTS, NAMES
from tools.bench.tracks import Track
from tools.train.codec_space import SPACES, fit_shared, fit_space


@pytest.fixture(scope="module")
def tracks() -> list[Track]:
    """Return one track of random motion in every direction."""
    rng = np.random.default_rng(2)
    motion = rng.normal(0, 60, (200, CONTROL_POINT_COUNT, 3)).astype(np.float32)
    frames = [MotionFrame(number / 15, displacements, TYPICAL_POSE) for number, displacements in enumerate(motion)]
    return [Track("random", frames, np.full(len(frames), 0.2), Fapu(6, 6, 6, 6, 6))]


@pytest.mark.parametrize("name", SPACES)
def test_synthesis_inverts_analysis(name: str, tracks: list[Track]) -> None:
    arrays = fit_space(name, SPACES[name], tracks)
    product = arrays[f"{name}_synthesis"] @ arrays[f"{name}_analysis"]
    np.testing.assert_allclose(product, np.eye(SPACES[name].components), atol=1e-5)
    assert len(arrays[f"{name}_stagger"]) == 6 + SPACES[name].components


def test_a_step_along_a_curve_is_shorter_where_curves_are_measured(tracks: list[Track]) -> None:
    """The length in the space of a displacement along the gradient is the number of steps that it takes."""
    gradient = GRADIENTS[NAMES.index("brow_knit")].reshape(-1)
    length = {}
    for name, space in SPACES.items():
        wide = type(space)(150, space.vertical, space.pose_step, space.curve_weight, space.curve_weights)
        length[name] = np.linalg.norm(gradient @ fit_space(name, wide, tracks)[f"{name}_analysis"])
    assert length["expressions"] > 2 * length["points"]


def test_the_pose_is_as_fine_in_both_spaces(tracks: list[Track]) -> None:
    units = {name: fit_space(name, space, tracks)[f"{name}_pose_unit"] for name, space in SPACES.items()}
    np.testing.assert_allclose(units["expressions"], units["points"] * SPACES["expressions"].pose_step, rtol=1e-6)


def test_all_profiles_share_the_typical_face(tracks: list[Track]) -> None:
    shared = fit_shared(tracks)
    assert float(shared["usual_log_scale"]) == pytest.approx(TYPICAL_POSE[5])
    assert shared["correction"].shape == (CONTROL_POINT_COUNT, 3) and (shared["correction"] > 0).all()
