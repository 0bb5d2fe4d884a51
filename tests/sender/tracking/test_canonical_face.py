from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conf.errors import ModelError
from conf.sender.tracking.canonical_face import FILE_NAME, CanonicalFace, parse_canonical_face, read_canonical_face


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


@given(st.binary(max_size=200))
def test_any_other_bytes_raise_a_value_error(data: bytes) -> None:
    with pytest.raises(ValueError):
        parse_canonical_face(data)


def test_a_truncated_file_is_refused(models: Path) -> None:
    data = (models / FILE_NAME).read_bytes()
    for size in range(0, len(data) - 2, 997):  # the last two bytes only select the source of the landmarks
        with pytest.raises(ValueError, match=r"cut off|not the face geometry|unknown wire type|longer than ten bytes"):
            parse_canonical_face(data[:size])


def test_the_message_for_a_missing_file_names_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        read_canonical_face(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / FILE_NAME} cannot be read (")
    assert str(caught.value).endswith("): run `conf models fetch` to get it again.")
