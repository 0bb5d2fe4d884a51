"""The tracker's files and clips, for the tests that need them."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conf.sender.capture.clip import open_clip
from conf.sender.tracking.canonical_face import CanonicalFace, load_canonical_face
from tests.support.short_clips import empty_clip, short_clip

__all__ = ["empty_clip", "short_clip"]


@pytest.fixture(scope="session")
def canonical() -> CanonicalFace:
    return load_canonical_face()


@pytest.fixture(scope="session")
def carphone(carphone_clip: Path) -> list[NDArray[np.uint8]]:
    """The first 20 frames of Carphone."""
    with open_clip(carphone_clip) as clip:
        frames = [clip.read() for _ in range(20)]
    return [frame.pixels for frame in frames if frame is not None]
