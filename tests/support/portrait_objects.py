"""Example objects for tests of portraits."""

import io

import numpy as np
from PIL import Image

from conf.protocol.portrait.background import Background
from conf.protocol.portrait.dct_coding import plane_shapes
from conf.protocol.portrait.patch import Patch
from conf.protocol.portrait.photo import Photo
from conf.protocol.portrait.probability_model import load_portrait_model
from conf.protocol.portrait.view import View
from conf.protocol.portrait.vp8 import strip_riff


def webp(width: int, height: int) -> bytes:
    """Return a WebP file of a gradient."""
    ramp = np.linspace(0, 255, width, dtype=np.uint8)
    pixels = np.stack([np.tile(ramp, (height, 1))] * 3, axis=2)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "WEBP", quality=50)
    return file.getvalue()


def example_photo(number: int = 1) -> Photo:
    """Return a photo with random points."""
    rng = np.random.default_rng(number)
    model = load_portrait_model()
    points = rng.uniform(-9, 9, model.face.mean.shape)
    controls = len(model.neutral_difference_scale)
    return Photo(
        number,
        (320, 240),
        np.array([0.1, -0.2, 0.05, 0.02, -0.1, -3.4]),
        points,
        points[:controls] + rng.normal(0, 0.3, (controls, 3)),
        (6.4, 5.0, 2.5, 5.2, 0.9),
        rng.uniform(0, 1, (30, 2)),
        strip_riff(webp(160, 120)),
    )


def example_patch(photo_number: int = 1, region: int = 0) -> Patch:
    """Return a patch with random points, and a few coefficients in every second row of blocks."""
    rng = np.random.default_rng(3)
    known = load_portrait_model().regions[region]
    descriptor = rng.integers(-100, 100, len(known.descriptor_scale)).astype(np.int8)
    planes = [np.zeros(shape, np.int64) for shape in plane_shapes(48, 42)]
    for plane in planes:
        plane[::2, :, :5] = rng.integers(-9, 10, (*plane[::2].shape[:2], 5))
    return Patch(photo_number, region, 3, descriptor, rng.uniform(0, 1, known.points.mean.shape), (48, 42), 7, planes)


def example_view(photo_number: int = 1) -> View:
    """Return a view with random points."""
    points = np.random.default_rng(4).uniform(-9, 9, load_portrait_model().neutral_difference_scale.shape)
    pose = np.array([0.1, 0.2, 0.05, 0.02, -0.1, -3.4])
    return View(photo_number, 2, pose, points, (0.25, 0.125, 0.75, 0.875), strip_riff(webp(80, 90)))


def example_background(photo_number: int = 1) -> Background:
    """Return a background with a gradient."""
    return Background(photo_number, (0.125, 0.25, 0.5, 0.75), strip_riff(webp(40, 30)))
