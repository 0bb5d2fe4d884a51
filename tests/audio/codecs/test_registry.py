"""Codecs by name; what is unknown or missing is explained in a sentence."""

import sys

import pytest

from conf.audio.codecs.codec2 import MISSING as CODEC2_MISSING
from conf.audio.codecs.opus_library import MISSING as OPUS_MISSING
from conf.audio.codecs.opus_library import load_opus
from conf.audio.codecs.registry import VOICE_CODECS, create_decoder, create_encoder, find_codec_fault
from conf.errors import AudioError


def test_all_codecs_work_here_best_first() -> None:
    assert VOICE_CODECS == ("opus", "codec2")
    assert [find_codec_fault(name) for name in VOICE_CODECS] == [None, None]


@pytest.mark.parametrize("create", [create_encoder, create_decoder])
def test_an_unknown_codec_is_named_cut_to_the_length_of_a_name(create: object) -> None:
    with pytest.raises(AudioError, match=r"voice in a codec unknown here \('lyra9lyra9lyra9l'\): a newer version"):
        create("lyra9" * 9, 3200, 20)  # type: ignore[operator]


def test_a_missing_libcodec2_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pycodec2.pycodec2", None)
    assert find_codec_fault("codec2") == CODEC2_MISSING
    assert find_codec_fault("opus") is None


def test_a_missing_libopus_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.audio.codecs.opus_library._candidates", lambda: iter(["no/such/libopus"]))
    load_opus.cache_clear()
    assert find_codec_fault("opus") == OPUS_MISSING
    monkeypatch.undo()
    load_opus.cache_clear()
    assert find_codec_fault("opus") is None
