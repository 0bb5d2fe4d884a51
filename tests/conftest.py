"""Settings for every test: strict floating point, and Hypothesis in a fast and a deep profile."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from conf.sender.models import fetch_demo_clip

os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # read once, by whoever opens the first clip

settings.register_profile("fast", max_examples=60, deadline=None, derandomize=True)
settings.register_profile(
    "deep", max_examples=5000, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fast"))

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(autouse=True)
def _strict_floats() -> object:
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


@pytest.fixture
def shared() -> Path:
    """The folder of clips and tracks that does not belong to the repository."""
    if not SHARED.is_dir():
        pytest.skip("the clips and tracks beside the repository are not here")
    return SHARED


@pytest.fixture(scope="session")
def demo_clip() -> Path:
    """The sample clip of `conf demo`, fetched the first time."""
    return fetch_demo_clip()
