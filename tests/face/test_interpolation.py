import numpy as np

from conf.face.interpolation import smoothstep


def test_smoothstep_is_clamped_and_flat_at_both_ends() -> None:
    assert smoothstep([-1.0, 0.0, 0.5, 1.0, 2.0]).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert np.all(smoothstep([1e-4, 1 - 1e-4]) * [1, -1] < [1e-7, -1 + 1e-7])


def test_smoothstep_rises_everywhere() -> None:
    assert (np.diff(smoothstep(np.linspace(0, 1, 100))) > 0).all()
