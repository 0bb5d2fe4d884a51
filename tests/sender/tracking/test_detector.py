from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from conf.sender.tracking.detector import (
    DetectedFace,
    FaceDetector,
    caller_score,
    decode,
    iou,
    make_anchors,
    tiles,
    weighted_nms,
)


def face(left: float, top: float, side: float, score: float = 0.9) -> DetectedFace:
    return DetectedFace(np.array([left, top, left + side, top + side]), np.full((2, 2), left), score)


def test_there_are_896_anchors_inside_the_square() -> None:
    anchors = make_anchors()
    assert anchors.shape == (896, 2)
    assert np.allclose(anchors[:3], [[1 / 32, 1 / 32], [1 / 32, 1 / 32], [3 / 32, 1 / 32]])
    assert np.allclose(anchors[512:519], [[1 / 16, 1 / 16]] * 6 + [[3 / 16, 1 / 16]])
    assert np.allclose(anchors.mean(axis=0), 0.5)


def test_outputs_are_offsets_in_pixels_from_their_anchor() -> None:
    output = np.zeros((1, 16))
    output[0, :8] = [12.8, 0, 64, 32, -12.8, 6.4, 12.8, 6.4]
    boxes, eyes = decode(output, np.array([[0.5, 0.5]]))
    assert np.allclose(boxes, [[0.35, 0.375, 0.85, 0.625]])
    assert np.allclose(eyes, [[[0.4, 0.55], [0.6, 0.55]]])


def test_overlapping_detections_are_averaged_by_score() -> None:
    merged = weighted_nms([face(0, 0, 10, 0.6), face(1, 0, 10, 0.9), face(100, 0, 10, 0.7)])
    assert [m.score for m in merged] == [0.9, 0.7]
    assert merged[0].box[0] == pytest.approx(0.6)
    assert merged[1].box[0] == 100


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0, 50), st.floats(0, 50), st.floats(1, 30), st.floats(0.5, 1)), max_size=12))
def test_merged_faces_are_fewer_and_keep_the_best_score(found: list[tuple[float, float, float, float]]) -> None:
    faces = [face(*f) for f in found]
    merged = weighted_nms(faces)
    assert len(merged) <= len(faces)
    assert (len(merged) > 0) == (len(faces) > 0)
    assert max((m.score for m in merged), default=0) == max((f.score for f in faces), default=0)


def test_iou_of_boxes() -> None:
    assert iou(face(0, 0, 10).box, face(0, 0, 10).box) == 1
    assert iou(face(0, 0, 10).box, face(5, 0, 10).box) == pytest.approx(1 / 3)
    assert iou(face(0, 0, 10).box, face(20, 0, 10).box) == 0
    assert iou(face(0, 0, 0).box, face(0, 0, 0).box) == 0


@pytest.mark.slow
@given(st.integers(64, 2000), st.integers(64, 2000))
def test_tiles_cover_the_image_and_stay_inside(width: int, height: int) -> None:
    squares = list(tiles(width, height))
    side = squares[0][1]
    lefts, tops = sorted({left for (left, _), _ in squares}), sorted({top for (_, top), _ in squares})
    for starts, length in ((lefts, width), (tops, height)):
        assert starts[0] == 0
        assert starts[-1] + side == pytest.approx(length)
        assert all(b - a <= side / 2 + 1e-6 for a, b in pairwise(starts))


def test_the_large_and_central_face_comes_first() -> None:
    middle = np.array([160.0, 120.0])
    assert caller_score(face(100, 80, 60), middle) > caller_score(face(100, 80, 30), middle)
    assert caller_score(face(130, 90, 60), middle) > caller_score(face(0, 0, 60), middle)


def test_a_face_is_detected_in_its_position(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    [found] = FaceDetector(models).detect(carphone[0])
    assert 60 < found.box[0::2].mean() < 110
    assert 30 < found.box[1::2].mean() < 90
    assert found.eyes[0, 0] < found.eyes[1, 0]  # the subject's right eye is on the image's left


@pytest.mark.slow
def test_a_small_face_is_detected_in_tiles(models: Path, carphone: list[NDArray[np.uint8]]) -> None:
    wide = np.full((720, 1280, 3), 90, np.uint8)
    small = cv2.resize(carphone[0], (264, 216))  # the face is then 75 px in 1280: a seventeenth
    wide[400:616, 900:1164] = small
    [found] = FaceDetector(models).detect(wide)
    assert 990 < found.box[0::2].mean() < 1065
    assert 445 < found.box[1::2].mean() < 535


def test_no_face_is_detected_in_an_empty_image(models: Path) -> None:
    assert FaceDetector(models).detect(np.full((480, 640, 3), 127, np.uint8)) == []
    assert FaceDetector(models).detect(np.zeros((1, 1, 3), np.uint8)) == []
