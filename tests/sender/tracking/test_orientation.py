from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.output.video_writer import VideoWriter
from conf.sender.capture.frame import Frame
from conf.sender.tracking.detector import DetectedFace, FaceDetector
from conf.sender.tracking.orientation import (
    CAMERA_STEP,
    SCAN_STEP,
    VOTES,
    OrientationEstimator,
    UprightCamera,
    find_turns,
    open_upright_clip,
    uprightness,
)

Image = NDArray[np.uint8]


def face(score: float, *, angle: float = 0.0) -> DetectedFace:
    """Return a face whose eyes lie on a line at an angle, radians, clockwise on the screen."""
    half = np.array([np.cos(angle), np.sin(angle)])
    return DetectedFace(np.array([0.0, 0.0, 10.0, 10.0]), np.array([-half, half]), score)


@dataclass
class FakeDetector:
    """Sees a face with the score that the image's first pixel, of the four corners in turn, has in percent."""

    calls: int = 0

    def detect(self, pixels: Image, *, small_faces: bool) -> list[DetectedFace]:
        assert not small_faces
        self.calls += 1
        score = pixels[0, 0, 0] / 100
        return [face(score)] if score > 0.5 else []


def image(up: int, left: int = 0, down: int = 0, right: int = 0) -> Image:
    """Return an image in which FakeDetector gives scores, in percent, after 0, 1, 2 and 3 quarter turns."""
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[0, 0], pixels[0, -1], pixels[-1, -1], pixels[-1, 0] = up, left, down, right
    return pixels


@dataclass
class FakeCamera:
    images: list[Image]
    fps: float = 30.0
    size: tuple[int, int] = (8, 8)
    reads: int = field(default=0)
    releases: int = 0

    def release(self) -> None:
        self.releases += 1

    def read(self) -> Frame:
        self.reads += 1
        return Frame(self.images[min(self.reads, len(self.images)) - 1], self.reads / 30)


def estimator(**options: Any) -> OrientationEstimator:
    return OrientationEstimator(FakeDetector(), **options)  # type: ignore[arg-type]


def test_one_upright_face_decides() -> None:
    estimated = estimator()
    estimated.add(image(90, 60, 84, 60))
    assert estimated.turns == 0 and not estimated.suspicious


@pytest.mark.parametrize(("pixels", "turns"), [((75, 0, 92, 0), 2), ((20, 90, 0, 60), 1), ((60, 0, 0, 90), 3)])
def test_several_images_must_agree_to_turn(pixels: tuple[int, ...], turns: int) -> None:
    estimated = estimator()
    for _ in range(VOTES - 1):
        estimated.add(image(*pixels))
        assert estimated.turns is None and estimated.suspicious
    estimated.add(image(*pixels))
    assert estimated.turns == turns


@pytest.mark.parametrize("pixels", [(0, 0, 0, 0), (55, 0, 68, 74), (88, 0, 92, 0)], ids=["none", "low", "close"])
def test_images_without_a_clear_face_decide_nothing(pixels: tuple[int, ...]) -> None:
    estimated = estimator()
    for _ in range(2 * VOTES):
        estimated.add(image(*pixels))
    assert estimated.turns is None and not estimated.suspicious


def test_only_candidates_are_tried() -> None:
    estimated = estimator(candidates=(0, 2))
    for _ in range(VOTES):
        estimated.add(image(20, 95, 60, 95))
    assert estimated.turns is None


def test_uprightness_falls_with_the_angle_of_the_eyes() -> None:
    assert uprightness(face(0.9)) == pytest.approx(0.9)
    assert uprightness(face(0.9, angle=np.pi / 3)) == pytest.approx(0.45)
    assert uprightness(face(0.9, angle=np.pi / 2)) == pytest.approx(0, abs=1e-9)
    assert uprightness(face(0.9, angle=np.pi)) == pytest.approx(-0.9)


def test_an_upright_camera_is_read_frame_by_frame() -> None:
    images = [image(0)] * CAMERA_STEP + [image(91, 0, 70, 0)] * 5
    camera, detector = FakeCamera(images), FakeDetector()
    upright = UprightCamera(camera, detector)  # type: ignore[arg-type]
    for expected in images:
        assert np.array_equal(upright.read().pixels, expected)
    assert camera.reads == len(images) and detector.calls == 4  # one empty and one clear image, in two orientations
    assert (upright.fps, upright.size) == (30.0, (8, 8))


def test_an_upright_camera_passes_its_release_on() -> None:
    camera = FakeCamera([])
    UprightCamera(camera, FakeDetector()).release()  # type: ignore[arg-type]
    assert camera.releases == 1


def test_a_camera_upside_down_is_turned_before_any_image_of_a_face_is_given() -> None:
    turned, notes = image(75, 0, 92, 0), list[str]()
    camera = FakeCamera([image(0), *[turned] * 20])
    upright = UprightCamera(camera, FakeDetector(), on_note=notes.append)  # type: ignore[arg-type]
    frames = [upright.read() for _ in range(CAMERA_STEP + 4)]
    assert np.array_equal(frames[-1].pixels, turned[::-1, ::-1]) and frames[-1].pixels.flags.c_contiguous
    assert np.array_equal(frames[CAMERA_STEP].pixels, turned[::-1, ::-1])
    assert frames[CAMERA_STEP].timestamp == camera_time(CAMERA_STEP + VOTES)
    assert notes == ["the camera is upside down: its images are turned"]


def camera_time(reads: int) -> float:
    return reads / 30


def test_a_single_doubtful_image_does_not_hold_a_camera_back() -> None:
    camera = FakeCamera([image(75, 0, 92, 0), *[image(0)] * 9])
    upright = UprightCamera(camera, FakeDetector())  # type: ignore[arg-type]
    upright.read()
    assert camera.reads == 2


@pytest.mark.slow
@pytest.mark.parametrize("turns", range(4))
def test_a_real_clip_is_turned_upright(models: Path, carphone: list[Image], tmp_path: Path, turns: int) -> None:
    path, notes = tmp_path / "clip.avi", list[str]()
    with VideoWriter(path, fps=25.0) as writer:
        for pixels in carphone[:8]:
            writer.write(np.ascontiguousarray(np.rot90(pixels, -turns)))
    assert find_turns(path, FaceDetector(models)) == turns
    with open_upright_clip(path, models, on_note=notes.append) as clip:
        frame = clip.read()
    assert frame is not None and clip.size == carphone[0].shape[1::-1]
    assert np.abs(frame.pixels.astype(int) - carphone[0]).mean() < 6  # grey levels: the writer compresses
    note = {0: [], 1: ["lies on its side"], 2: ["is upside down"], 3: ["lies on its side"]}[turns]
    assert notes == [f"{path} {text}: its frames are turned" for text in note]


@pytest.mark.slow
def test_a_face_that_appears_later_in_a_clip_is_examined(models: Path, carphone: list[Image], tmp_path: Path) -> None:
    path, empty = tmp_path / "clip.avi", np.full_like(carphone[0], 100)
    with VideoWriter(path, fps=25.0) as writer:
        for pixels in [*[empty] * (3 * SCAN_STEP), *carphone[:10]]:
            writer.write(np.ascontiguousarray(pixels[::-1, ::-1]))
    assert find_turns(path, FaceDetector(models)) == 2


@pytest.mark.slow
def test_no_clip_is_turned_by_mistake(models: Path, shared: Path) -> None:
    detector = FaceDetector(models)
    clips = [path for path in sorted((shared / "media").iterdir()) if path.suffix in {".mp4", ".mpg", ".mov"}]
    assert len(clips) > 10
    assert {path.name: find_turns(path, detector) for path in clips} == {path.name: 0 for path in clips}
