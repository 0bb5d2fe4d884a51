import numpy as np
import pytest

from conf.sender.tracking.canonical_face import CanonicalFace


def test_the_canonical_face_is_symmetric_and_in_centimetres(canonical: CanonicalFace) -> None:
    assert canonical.vertices.shape == (468, 3)
    assert canonical.triangles.shape == (898, 3)
    assert canonical.triangles.min() == 0
    assert canonical.triangles.max() == 467
    eyes = (canonical.vertices[[33, 133]].mean(axis=0), canonical.vertices[[263, 362]].mean(axis=0))
    assert np.linalg.norm(eyes[1] - eyes[0]) == pytest.approx(6.30, abs=0.01)
    assert eyes[1][0] > 0  # the subject's left is on +x
    assert canonical.vertices[10, 1] > canonical.vertices[152, 1]  # the forehead is above the chin
    assert np.allclose(canonical.vertices[33] * [-1, 1, 1], canonical.vertices[263])
    assert len(canonical.rigid) == 33
    assert canonical.weights.sum() == pytest.approx(1.055, abs=0.001)
