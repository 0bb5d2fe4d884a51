from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.sender.capture.clip import open_clip
from conf.sender.tracking.inference import Backend
from conf.sender.tracking.tracker import BLENDSHAPE_INTERVAL, FaceTracker
from tests.sender.tracking.test_inference import BACKENDS


def frames(path: Path, count: int) -> list[NDArray[np.uint8]]:
    with open_clip(path) as clip:
        return [frame.pixels for _ in range(count) if (frame := clip.read()) is not None]


@pytest.mark.slow
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("clip", ["cap12.mp4", "grid_lbax4n.mpg", "man_smiles.mp4", "woman_hand_over_face.mp4"])
def test_landmarks_agree_with_mediapipe(models: Path, shared: Path, clip: str, backend: Backend) -> None:
    track = np.load(shared / "motion" / f"{Path(clip).stem}.npz")
    oracle = track["landmarks"] / track["scale"]
    tracker = FaceTracker(models, backend=backend)
    for i, pixels in enumerate(frames(shared / "media" / clip, 12)):
        tracking = tracker.track(pixels)
        assert tracking is not None
        assert tracking.presence > 0.9
        error = np.abs(tracking.landmarks - oracle[i]).mean()
        # the first frame is predicted twice here and once in MediaPipe
        assert error < (1.0 if i == 0 else 0.3), f"frame {i}"


@pytest.mark.slow
def test_a_face_that_leaves_and_returns_is_tracked(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    tracker = FaceTracker(models)
    empty = np.full_like(carphone[0], 100)
    shown = [carphone[0], carphone[1], empty, empty, carphone[2][:, ::-1].copy(), carphone[3][:, ::-1].copy()]
    assert [tracker.track(pixels) is not None for pixels in shown] == [True, True, False, False, True, True]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("clip", "expected"), [("no_face.mp4", "." * 99), ("face_then_none.mov", "1" * 72 + "." * 97)], ids=lambda v: v[:12]
)
def test_letters_and_clouds_are_no_face(models: Path, shared: Path, clip: str, expected: str) -> None:
    tracker = FaceTracker(models)
    images = frames(shared / "media" / clip, 200)[::4]
    found = "".join("1" if tracker.track(pixels) else "." for pixels in images)
    assert found == expected[: len(images) * 4 : 4]


@pytest.mark.slow
def test_the_tracked_face_is_followed_although_a_larger_one_appears(
    models: Path, carphone: list[NDArray[np.uint8]]
) -> None:
    tracker = FaceTracker(models)
    height, width = carphone[0].shape[:2]
    alone = np.full((2 * height, 3 * width, 3), 90, np.uint8)
    alone[:height, :width] = carphone[0]
    first = tracker.track(alone)
    assert first is not None
    both = alone.copy()
    both[:, width:] = np.kron(carphone[0], np.ones((2, 2, 1), np.uint8))
    second = tracker.track(both)
    assert second is not None
    assert np.abs(second.landmarks - first.landmarks).mean() < 1
    fresh = FaceTracker(models).track(both)
    assert fresh is not None
    assert fresh.landmarks[:, 0].min() > width  # a new tracker follows the larger face


@pytest.mark.slow
@pytest.mark.parametrize("backend", BACKENDS)
def test_blendshapes_have_an_age(models: Path, carphone: list[NDArray[np.uint8]], backend: Backend) -> None:
    tracker = FaceTracker(models, backend=backend)
    tracked = [tracker.track(pixels) for pixels in carphone[:7]]
    ages = [tracking.blendshapes_age for tracking in tracked if tracking]
    assert ages == [i % BLENDSHAPE_INTERVAL[backend] for i in range(7)]


@pytest.mark.parametrize("size", [(1, 1), (3, 500), (500, 3), (16, 16)])
def test_odd_images_have_no_face(models: Path, size: tuple[int, int]) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (*size, 3), dtype=np.uint8)
    assert FaceTracker(models).track(noise) is None
