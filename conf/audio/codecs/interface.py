"""What a voice codec is: an encoder and a decoder of frames of a fixed duration, 16 kHz mono int16 on both sides."""

from typing import Protocol

from conf.audio.samples import Samples


class VoiceEncoder(Protocol):
    """The encoder of one talker.

    sample_rate : of what `encode` takes, samples a second
    frame_samples : samples a frame
    """

    sample_rate: int
    frame_samples: int

    def encode(self, frame: Samples, /) -> bytes:
        """Return the code of one frame, (frame_samples,) int16, at most MAX_FRAME_BYTES.

        A codec of fixed size returns its bits left-aligned in as few bytes as hold them, zero bits after them.
        """


class VoiceDecoder(Protocol):
    """The decoder of one talker.

    sample_rate : of what `decode` returns, samples a second
    frame_samples : samples a frame
    delay_s : by how much the decoded sound lags behind what the encoder took, s, both ends together
    """

    sample_rate: int
    frame_samples: int
    delay_s: float

    def decode(self, data: bytes, /) -> Samples:
        """Return one frame, (frame_samples,) int16. Data that no encoder of this format made is concealed as lost."""

    def conceal(self) -> Samples:
        """Return one frame in place of one that was lost; it goes on from the last and fades after some frames."""


MAX_FRAME_BYTES = 255  # a frame's length is one byte on the wire
