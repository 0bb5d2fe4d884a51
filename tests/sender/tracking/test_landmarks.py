from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.sender.tracking.landmarks import CROP_SHARE, INPUT_SIZE, Crop, LandmarkNetwork

CAR = Crop(np.array([84.0, 62.0]), 100.0, 0.0)  # around the man's face in the first frame


@given(st.floats(-500, 500), st.floats(-500, 500), st.floats(1, 1000), st.floats(-3.1, 3.1))
def test_the_crop_maps_its_middle_and_sides(x: float, y: float, side: float, angle: float) -> None:
    matrix = Crop(np.array([x, y]), side, angle).matrix()
    to_picture = lambda u, v: matrix @ [u, v, 1]  # noqa: E731
    assert np.allclose(to_picture(INPUT_SIZE / 2, INPUT_SIZE / 2), [x, y])
    across = to_picture(INPUT_SIZE, 0) - to_picture(0, 0)
    assert np.allclose(across, side * np.array([np.cos(angle), np.sin(angle)]))


def test_the_crop_turns_until_the_eyes_are_level() -> None:
    points = np.array([[0.0, 0], [20, 10]])
    crop = Crop.around_points(points, np.array([[5.0, 5], [15, 15]]))
    assert crop.angle == pytest.approx(np.pi / 4)
    assert crop.side == 20 * CROP_SHARE
    assert np.allclose(crop.centre, [10, 5])


def test_a_face_is_present_and_background_is_not(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    finder = LandmarkNetwork(models)
    landmarks, presence = finder.predict(carphone[0], CAR)
    assert presence > 0.9
    assert landmarks.shape == (478, 3)
    assert landmarks[33, 0] < landmarks[263, 0]
    assert landmarks[10, 1] < landmarks[152, 1]
    assert landmarks[1, 2] < landmarks[234, 2]  # z points away: the nose is nearer than the ear
    _, absence = finder.predict(carphone[0], Crop(np.array([30.0, 100.0]), 60.0, 0.0))
    assert absence < 0.1


def test_landmarks_turn_with_the_picture(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    finder = LandmarkNetwork(models)
    upright, _ = finder.predict(carphone[0], CAR)
    height = carphone[0].shape[0]
    turned_picture = np.rot90(carphone[0]).copy()  # counterclockwise: (x, y) goes to (y, width - 1 - x)
    width = carphone[0].shape[1]
    crop = Crop(np.array([62.0, width - 1 - 84.0]), 100.0, -np.pi / 2)
    turned, presence = finder.predict(turned_picture, crop)
    assert presence > 0.9
    back = np.stack([width - 1 - turned[:, 1], turned[:, 0]], axis=1)
    assert np.abs(back - upright[:, :2]).mean() < 0.5
    assert height == 144
