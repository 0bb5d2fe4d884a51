"""A drawn person to photograph, for tests without a camera, and the portrait objects of it."""

import io
from dataclasses import astuple

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from conf.face.control_points import CONTROL_POINT_COUNT
from conf.face.fapu import Fapu
from conf.face.head_pose import HeadPose
from conf.face.portrait.patch_features import FEATURES
from conf.face.portrait.patch_prediction import forward_dct, predict_patch
from conf.face.portrait.photographed_face import project
from conf.protocol.portrait.patch import Patch, step_size
from conf.protocol.portrait.photo import Photo
from conf.protocol.portrait.view import View
from conf.protocol.portrait.vp8 import strip_riff
from tests.support.synthetic_portrait import POSE, face_points

SIZE = (320, 240)
SKIN, LIPS, WALL = (130, 160, 210), (90, 90, 180), (160, 140, 40)  # BGR


def to_pixels(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return positions (k, 2), image heights from the centre, in px from the upper left corner."""
    return positions * (SIZE[1], -SIZE[1]) + (SIZE[0] / 2, SIZE[1] / 2)


def draw_person() -> NDArray[np.uint8]:
    """Return (240, 320, 3) uint8 BGR: an oval face with eyes and lips before a plain wall."""
    pixels = np.full((SIZE[1], SIZE[0], 3), WALL, np.uint8)
    x, y = np.rint(to_pixels(POSE.position[None])[0]).astype(int)
    cv2.rectangle(pixels, (x - 60, y + 60), (x + 60, SIZE[1]), (60, 60, 60), -1)
    cv2.ellipse(pixels, (x, y), (54, 72), 0, 0, 360, SKIN, -1)
    points = to_pixels(project(face_points(), POSE))
    for index in (16, 17):
        cv2.circle(pixels, tuple(np.rint(points[index]).astype(int).tolist()), 5, (40, 40, 40), -1)
    cv2.ellipse(pixels, tuple(np.rint(points[1]).astype(int).tolist()), (17, 5), 5, 0, 360, LIPS, -1)
    return pixels


def encode_vp8(pixels: NDArray[np.uint8]) -> bytes:
    """Return the VP8 frame of an image (H, W, 3) uint8 BGR."""
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels[..., ::-1])).save(file, "WEBP", quality=80)
    return strip_riff(file.getvalue())


def make_photo(number: int = 1) -> Photo:
    """Return the photo of the drawn person."""
    points = face_points()
    neutral = points[:CONTROL_POINT_COUNT]
    outline = np.array([(0.3, 1.0), (0.33, 0.72), (0.35, 0.4), (0.52, 0.2), (0.7, 0.4), (0.72, 0.72), (0.75, 1.0)])
    fapu, frame = astuple(Fapu.measure(neutral)), encode_vp8(draw_person())
    return Photo(number, SIZE, POSE.to_vector(), points, neutral, fapu, outline, frame)


def make_view(slot: int = 0, *, pose: HeadPose = POSE, colour: tuple[int, int, int] | None = None) -> View:
    """Return a view of the middle half of the drawn person, or of one colour (BGR), in a pose."""
    pixels = draw_person()[:, 80:240]
    if colour is not None:
        pixels[:] = colour
    points = face_points()[:CONTROL_POINT_COUNT]
    return View(1, slot, pose.to_vector(), points, (0.25, 0.0, 0.75, 1.0), encode_vp8(pixels))


def make_patch(
    region: int = 0, slot: int = 0, *, photo_number: int = 1, colour: tuple[int, int, int] = (255, 0, 0)
) -> Patch:
    """Return a patch of one colour (BGR); all values of its descriptor are 10."""
    feature = FEATURES[region]
    points = project(face_points(), POSE)[list(feature.points)]
    low, high = points.min(axis=0) - 0.05, points.max(axis=0) + 0.05
    positions = (points - (low[0], high[1])) / ((high[0] - low[0]), -(high[1] - low[1]))
    descriptor = np.full(len(feature.descriptor(np.zeros((CONTROL_POINT_COUNT, 3)))), 10, np.int8)
    size = (60, 40)
    predicted = predict_patch(draw_person(), points / (SIZE[0] / SIZE[1], -1.0) + 0.5, positions, size)
    planes = [plane / step_size(0) for plane in forward_dct(np.array(colour) - predicted)]
    return Patch(photo_number, region, slot, descriptor, positions, size, 0, planes)
