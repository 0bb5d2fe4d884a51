import numpy as np
import pytest

from conf.face.control_points import control_point_indices
from conf.face.fapu import Fapu
from conf.protocol.codec.expression_curves import load_curves
from conf.sender.motion.mean_face import MEAN_FACE
from tools.bench.expression_curves import REPORTED, reported_curves
from tools.train.curves import curve_gradients


def test_the_shipped_file_is_what_the_tool_writes() -> None:
    assert load_curves() == pytest.approx(curve_gradients(), rel=1e-6)


def test_curves_are_those_that_the_bench_reports() -> None:
    lengths, names = Fapu.measure(MEAN_FACE).lengths(), [name for name in REPORTED if name != "slant"]
    units = np.random.default_rng(0).normal(0, 20, (50, 3))
    still = control_point_indices(
        "eye", "brow", "nose", "nostril"
    )  # brows are measured from the bridge here, as landmarks there
    units[still] = 0.0
    positions = MEAN_FACE + np.stack([np.zeros((50, 3)), units * lengths])
    before, after = reported_curves(positions)
    kept = [list(REPORTED).index(name) for name in names]
    assert curve_gradients() @ units.reshape(-1) == pytest.approx((after - before)[kept], abs=1e-4)


def test_brows_are_measured_from_the_bridge_that_follows_the_corners_of_the_eyes() -> None:
    units = np.zeros((50, 3))
    units[control_point_indices("eye_inner_corner"), 1] = 100.0
    inner, outer, *others = (curve_gradients() @ units.reshape(-1)).tolist()
    assert inner == outer < -0.01
    assert others == [0.0] * len(others)
