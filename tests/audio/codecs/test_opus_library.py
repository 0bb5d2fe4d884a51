"""Where libopus is found."""

import ctypes

import pytest

from conf.audio.codecs import opus_library
from conf.audio.codecs.opus_library import load_opus
from conf.errors import AudioError


def test_the_library_is_that_of_the_wheel() -> None:
    first = next(opus_library._candidates())
    assert "libopus" in first and "av" in first
    assert load_opus()._name == first


def test_a_library_without_the_functions_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opus_library, "_candidates", lambda: iter([ctypes.util.find_library("c") or "libc.so.6"]))
    load_opus.cache_clear()
    with pytest.raises(AudioError, match="Opus is missing, so voice needs Codec2: install PyAV from its wheel"):
        load_opus()
    load_opus.cache_clear()
