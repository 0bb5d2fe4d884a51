from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.sender.tracking.landmarks import CROP_SCALE, INPUT_SIZE, Crop, LandmarkNetwork

CAR = Crop(np.array([84.0, 62.0]), 100.0, 0.0)  # around the man's face in the first frame


@pytest.mark.slow
@given(st.floats(-500, 500), st.floats(-500, 500), st.floats(1, 1000), st.floats(-3.1, 3.1))
def test_the_crop_maps_its_middle_and_its_sides(x: float, y: float, side: float, angle: float) -> None:
    matrix = Crop(np.array([x, y]), side, angle).matrix()
    assert np.allclose(matrix @ [INPUT_SIZE / 2, INPUT_SIZE / 2, 1], [x, y])
    across = matrix @ [INPUT_SIZE, 0, 1] - matrix @ [0, 0, 1]
    assert np.allclose(across, side * np.array([np.cos(angle), np.sin(angle)]))


def test_the_eyes_are_level_in_the_crop() -> None:
    points = np.array([[0.0, 0], [20, 10]])
    crop = Crop.around_points(points, np.array([[5.0, 5], [15, 15]]))
    assert crop.angle == pytest.approx(np.pi / 4)
    assert crop.side == 20 * CROP_SCALE
    assert np.allclose(crop.centre, [10, 5])


def test_presence_of_a_face_and_of_background(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    network = LandmarkNetwork(models)
    landmarks, presence = network.predict(carphone[0], CAR)
    assert presence > 0.9
    assert landmarks.shape == (478, 3)
    assert landmarks[33, 0] < landmarks[263, 0]
    assert landmarks[10, 1] < landmarks[152, 1]
    assert landmarks[1, 2] < landmarks[234, 2]  # z points away: the nose is nearer than the ear
    _, absence = network.predict(carphone[0], Crop(np.array([30.0, 100.0]), 60.0, 0.0))
    assert absence < 0.1


def test_landmarks_rotate_with_the_image(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    network = LandmarkNetwork(models)
    upright, _ = network.predict(carphone[0], CAR)
    rotated_image = np.rot90(carphone[0]).copy()  # counterclockwise: (x, y) goes to (y, width - 1 - x)
    width = carphone[0].shape[1]
    crop = Crop(np.array([62.0, width - 1 - 84.0]), 100.0, -np.pi / 2)
    rotated, presence = network.predict(rotated_image, crop)
    assert presence > 0.9
    back = np.stack([width - 1 - rotated[:, 1], rotated[:, 0]], axis=1)
    assert np.abs(back - upright[:, :2]).mean() < 0.5
