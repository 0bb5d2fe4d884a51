"""How voice is encoded and packed, and the packets and frames that cross the border to the audio side."""

from dataclasses import dataclass
from enum import Enum

from conf.errors import ProtocolError

MAX_FORMATS = 16  # known at a time
GRID_MS = 20  # packets start at multiples of this on the stream clock
MAX_CODEC_NAME = 16  # ASCII characters
MAX_BIT_RATE = 510_000  # of Opus; no codec for voice needs more
MAX_PACKET_MS = 1000
MAX_VARIABLE_FRAME = 255  # bytes: its length is one byte
MAX_NOISE_LEVEL = 127  # -dBFS, as in RFC 3389


@dataclass(frozen=True)
class VoiceFormat:
    """A codec with its settings, and how many of its frames make a packet.

    codec : name, for example opus or codec2
    bit_rate : bits a second; of a variable-size codec the target
    frame_ms : duration of a frame
    frames : in a packet
    fixed_size : every frame has frame_bits bits; otherwise each frame is a whole number of bytes
    repeated : each packet repeats so many frames of the one before it, the newest: who waits for them hears each frame
        so much later
    """

    codec: str
    bit_rate: int
    frame_ms: int
    frames: int
    fixed_size: bool
    repeated: int = 0

    @property
    def packet_ms(self) -> int:
        """Duration of a packet."""
        return self.frame_ms * self.frames

    @property
    def packet_s(self) -> float:
        """The same in seconds."""
        return self.packet_ms / 1000

    @property
    def frame_bits(self) -> int:
        """Bits of a frame; of a variable-size codec on average."""
        return self.bit_rate * self.frame_ms // 1000

    @property
    def coverage_s(self) -> float:
        """Duration of the voice in a packet, the repeated frames included."""
        return self.packet_s + self.repeated * self.frame_ms / 1000

    @property
    def nominal_bytes(self) -> int:
        """Bytes of a packet's data whose frames have the bit rate exactly, with lengths and repeated frames."""
        count = self.frames + self.repeated
        if self.fixed_size:
            return -(-count * self.frame_bits // 8)
        return count * -(-self.frame_bits // 8) + count - 1

    def check(self) -> None:
        """Raise ProtocolError if a receiver must not accept the format."""
        if not (0 < len(self.codec) <= MAX_CODEC_NAME and self.codec.isascii() and self.codec.isprintable()):
            raise ProtocolError("the name of a voice codec is not 1 to 16 ASCII characters")
        if not (0 < self.bit_rate <= MAX_BIT_RATE and self.frame_ms > 0 and self.frames > 0 and self.frame_bits > 0):
            raise ProtocolError("a voice format out of range")
        if not 0 <= self.repeated <= self.frames:
            raise ProtocolError("a voice packet that repeats more than the one before it")
        if self.packet_ms > MAX_PACKET_MS or self.packet_ms % GRID_MS:
            raise ProtocolError("voice packets of this duration are not allowed")


@dataclass(frozen=True)
class VoicePacket:
    """Encoded voice to send.

    timestamp : capture time of the first sample, seconds on the clock of MotionFrame.timestamp
    frames : format.frames of them, in time order; a frame of a fixed-size codec is left-aligned in whole bytes
    """

    timestamp: float
    format: VoiceFormat
    frames: tuple[bytes, ...]


@dataclass(frozen=True)
class VoiceFrame:
    """One received frame, or a gap of a frame's duration to be concealed.

    timestamp : of its first sample on the sender's stream clock, seconds
    data : as the encoder returned it; None if it is lost
    """

    timestamp: float
    format: VoiceFormat
    data: bytes | None


class VoiceState(Enum):
    """What a microphone does."""

    OFF = 0  # there is none, or it has failed
    SILENT = 1  # open, and nobody talks: the receiver plays comfort noise
    TALKING = 2
    MUTED = 3  # by its user
    NO_ROOM = 4  # open, but the limit of the rate leaves no room for voice
