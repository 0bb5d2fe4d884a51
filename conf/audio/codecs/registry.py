"""Find a voice codec by the name that travels in a stream's format. A new codec is a module and a row here."""

from collections.abc import Callable
from typing import NamedTuple

from conf.audio.codecs.interface import VoiceDecoder, VoiceEncoder
from conf.errors import AudioError


class _Codec(NamedTuple):
    """How to build a codec's halves for a bit rate and a frame duration in ms."""

    encoder: Callable[[int, int], VoiceEncoder]
    decoder: Callable[[int, int], VoiceDecoder]
    probe: tuple[int, int]  # a bit rate and a duration that it has


def _opus_encoder(bit_rate: int, frame_ms: int) -> VoiceEncoder:
    from conf.audio.codecs.opus import OpusEncoder

    return OpusEncoder(bit_rate, frame_ms)


def _opus_decoder(bit_rate: int, frame_ms: int) -> VoiceDecoder:
    from conf.audio.codecs.opus import OpusDecoder

    return OpusDecoder(frame_ms)


def _codec2_encoder(bit_rate: int, frame_ms: int) -> VoiceEncoder:
    from conf.audio.codecs.codec2 import Codec2Encoder

    return Codec2Encoder(bit_rate, frame_ms)


def _codec2_decoder(bit_rate: int, frame_ms: int) -> VoiceDecoder:
    from conf.audio.codecs.codec2 import Codec2Decoder

    return Codec2Decoder(bit_rate, frame_ms)


_CODECS = {
    "opus": _Codec(_opus_encoder, _opus_decoder, (6000, 60)),
    "codec2": _Codec(_codec2_encoder, _codec2_decoder, (1200, 40)),
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
