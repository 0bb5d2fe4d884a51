"""Freed memory is reused: blocks of an image's size come back at the same address, without new pages."""

import platform
import resource

import numpy as np
import pytest

from conf.sender.capture.allocator import keep_freed_memory


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="mallopt belongs to glibc")
def test_images_get_the_memory_of_freed_ones() -> None:
    assert keep_freed_memory()
    for _ in range(3):
        np.ones(8 << 20, np.uint8)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(50):
        np.ones(8 << 20, np.uint8)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before < 2048 * 10  # 2048 pages each if they are new


def test_elsewhere_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.CDLL", lambda name: object())
    assert keep_freed_memory.__wrapped__() is False
