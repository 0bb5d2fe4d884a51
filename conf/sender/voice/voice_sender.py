"""From captured sound to encoded packets: clean, cut, decide whether somebody talks, encode in the format asked for.

Strategy. Speech is noticed late: a talk spurt starts LOOK_BACK blocks before. A packet in which speech is noticed
leaves at once; one without waits for that long, for the beginning of a talk spurt after it.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from conf.audio.codecs.interface import VoiceEncoder
from conf.audio.codecs.registry import create_encoder
from conf.audio.processing import BLOCK_SAMPLES, VoiceBlock
from conf.audio.samples import SAMPLE_RATE, SILENCE_DBFS, AudioBlock, level_dbfs
from conf.protocol.voice.formats import MAX_NOISE_LEVEL, VoiceFormat, VoicePacket, VoiceState

if TYPE_CHECKING:
    from conf.sender.capture.sound import SoundSource  # with PyAV, which a microphone does not need

BLOCK_S = BLOCK_SAMPLES / SAMPLE_RATE
MAX_FILL_S = 0.5  # a longer gap in the captured sound begins the stream anew
MIN_GAP_S = 0.03  # capture times vary by less
LOOK_BACK = 2  # blocks: the speech probability comes 20 ms late
MAX_BUFFERED_S = 2.0  # of sound that waits to be sent


class SpeechProcessor(Protocol):
    """Cleans captured sound and tells which of it is voice; see conf.audio.processing."""

    @property
    def noise_dbfs(self) -> float: ...
    def process(self, block: AudioBlock, /) -> list[VoiceBlock]: ...


class VoiceOutlet(Protocol):
    """Where the encoded voice goes: the sending half of a call."""

    @property
    def voice_format(self) -> VoiceFormat | None: ...
    def send_voice(self, packet: VoicePacket, now: float, /) -> None: ...
    def set_voice_state(self, state: VoiceState, now: float, /, *, noise_level: int = MAX_NOISE_LEVEL) -> None: ...


class VoiceSender:
    """The voice of one caller.

    muted : the microphone is read but nothing of it is sent, nor what it captured before the change
    level_dbfs : of the newest 10 ms, after cleaning
    """

    def __init__(
        self,
        source: "SoundSource",
        processor: SpeechProcessor,
        *,
        encoders: Callable[[str, int, int], VoiceEncoder] = create_encoder,
    ) -> None:
        self.muted = False
        self.level_dbfs = SILENCE_DBFS
        self._source = source
        self._processor = processor
        self._encoders = encoders
        self._encoder: tuple[VoiceFormat, VoiceEncoder] | None = None
        self._blocks: deque[VoiceBlock] = deque()  # without a gap
        self._end: float | None = None  # capture time of what follows them
        self._overlaps = False  # whether sound was captured that lies before this
        self._packet_s: float | None = None  # duration of the next packet

    def poll(self, until: float, outlet: VoiceOutlet, now: float) -> None:
        """Send the packets that are complete at `until`, a time on the clock of the frames. Raises CameraError."""
        for captured in self._source.read(until):
            for block in self._processor.process(captured):
                self._append(block)
        if self.muted or outlet.voice_format is None:
            self._blocks.clear()
            outlet.set_voice_state(VoiceState.MUTED if self.muted else VoiceState.NO_ROOM, now)
            return
        while (voice_format := outlet.voice_format) and self._send_packet(voice_format, outlet, now):
            pass
        self._packet_s = voice_format.packet_s if voice_format else None
        while len(self._blocks) * BLOCK_S > MAX_BUFFERED_S:
            self._blocks.popleft()

    @property
    def due_in_s(self) -> float:
        """Return the seconds after which the next packet may be complete, 0 if there is no telling."""
        if self._end is None or self._packet_s is None:
            return 0.0
        start = self._blocks[0].timestamp if self._blocks else self._end
        missing_s = start + self._packet_s - self._end
        return missing_s if missing_s > 0 else BLOCK_S  # a whole packet waits for speech in the next block

    def close(self) -> None:
        """Release the file or device."""
        self._source.close()

    def _append(self, block: VoiceBlock) -> None:
        """Add a block; a short gap before it is filled with silence, what overlaps the last one is dropped."""
        gap = 0.0 if self._end is None else block.timestamp - self._end
        if abs(gap) > MAX_FILL_S:
            self._blocks.clear()
        elif gap < (-BLOCK_S / 2 if self._overlaps else -MIN_GAP_S):
            self._overlaps = True
            return
        elif gap > MIN_GAP_S:
            silence = replace(block, samples=np.zeros(BLOCK_SAMPLES, np.int16), active=False)
            self._blocks.extend(
                replace(silence, timestamp=block.timestamp - i * BLOCK_S) for i in range(round(gap / BLOCK_S), 0, -1)
            )
        self._overlaps = False
        self._blocks.append(block)
        self._end = block.timestamp + BLOCK_S
        self.level_dbfs = level_dbfs(block.samples)

    def _send_packet(self, voice_format: VoiceFormat, outlet: VoiceOutlet, now: float) -> bool:
        """Send the next packet, or the state of the microphone in its place. Returns False if it is not complete."""
        count = round(voice_format.packet_s / BLOCK_S)
        if len(self._blocks) < count:
            return False
        is_active = any(block.active for block in islice(self._blocks, count + LOOK_BACK))
        if not is_active:  # tell it before the look back ends: the other side expects voice
            outlet.set_voice_state(VoiceState.SILENT, now, noise_level=self._noise_level())
            if len(self._blocks) < count + LOOK_BACK:
                return False
        packet = [self._blocks.popleft() for _ in range(count)]
        if is_active:
            outlet.set_voice_state(VoiceState.TALKING, now, noise_level=self._noise_level())
            frames = self._encode(np.concatenate([block.samples for block in packet]), voice_format)
            outlet.send_voice(VoicePacket(packet[0].timestamp, voice_format, frames), now)
        return True

    def _noise_level(self) -> int:
        """Return the background noise in -dBFS; in steps of 6 dB, so that it is announced seldom."""
        return min(max(round(-self._processor.noise_dbfs / 6) * 6, 0), MAX_NOISE_LEVEL)

    def _encode(self, samples: NDArray[np.int16], voice_format: VoiceFormat) -> tuple[bytes, ...]:
        if self._encoder is None or self._encoder[0] != voice_format:
            encoder = self._encoders(voice_format.codec, voice_format.bit_rate, voice_format.frame_ms)
            self._encoder = (voice_format, encoder)
        return tuple(self._encoder[1].encode(frame) for frame in samples.reshape(voice_format.frames, -1))
