import itertools

import numpy as np
import pytest

from conf.face.mesh.axes import AXES, ORIENTATIONS, axes_rotation


def test_all_24_orientations_are_listed_once() -> None:
    pairs = {(up, front) for up, front in itertools.product(AXES, AXES) if up[-1] != front[-1]}
    assert len(ORIENTATIONS) == 24
    assert set(ORIENTATIONS) == pairs


@pytest.mark.parametrize(("up", "front"), ORIENTATIONS)
def test_the_rotation_is_proper_and_maps_up_and_front(up: str, front: str) -> None:
    rotation = axes_rotation(up, front)
    np.testing.assert_allclose(rotation @ AXES[up], [0, 1, 0])
    np.testing.assert_allclose(rotation @ AXES[front], [0, 0, 1])
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_invalid_axes_raise() -> None:
    with pytest.raises(ValueError, match="up must be one of x, -x, y, -y, z, -z, got 'w'"):
        axes_rotation("w", "z")
    with pytest.raises(ValueError, match="front must not lie on the same line as up"):
        axes_rotation("y", "-y")
