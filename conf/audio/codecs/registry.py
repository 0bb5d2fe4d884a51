"""Find a voice codec by the name that travels in a stream's format. A new codec is a module and a row here."""

from collections.abc import Callable
from typing import NamedTuple

from conf.audio.codecs.codec2 import Codec2Decoder, Codec2Encoder
from conf.audio.codecs.interface import VoiceDecoder, VoiceEncoder
from conf.audio.codecs.opus import OpusDecoder, OpusEncoder
from conf.errors import AudioError


class _Codec(NamedTuple):
    """How to build a codec's halves for a bit rate and a frame duration in ms."""

    encoder: Callable[[int, int], VoiceEncoder]
    decoder: Callable[[int, int], VoiceDecoder]
    probe: tuple[int, int]  # a bit rate and a duration that it has


_CODECS = {
    "opus": _Codec(OpusEncoder, lambda _, frame_ms: OpusDecoder(frame_ms), (6000, 60)),
    "codec2": _Codec(Codec2Encoder, Codec2Decoder, (1200, 40)),
}
VOICE_CODECS = tuple(_CODECS)  # best first


def create_encoder(codec: str, bit_rate: int, frame_ms: int) -> VoiceEncoder:
    """Return an encoder. Raises AudioError if the codec is unknown, lacks this format or its library is missing."""
    return _find(codec).encoder(bit_rate, frame_ms)


def create_decoder(codec: str, bit_rate: int, frame_ms: int) -> VoiceDecoder:
    """Return a decoder. Raises AudioError if the codec is unknown, lacks this format or its library is missing."""
    return _find(codec).decoder(bit_rate, frame_ms)


def find_codec_fault(codec: str) -> str | None:
    """Return why a codec cannot be used on this machine and what to do, or None if it can."""
    try:
        create_decoder(codec, *_find(codec).probe)
    except AudioError as error:
        return str(error)
    return None


def _find(codec: str) -> _Codec:
    if codec not in _CODECS:
        raise AudioError(f"voice in a codec unknown here ({codec[:16]!r}): a newer version of conf may know it.")
    return _CODECS[codec]
