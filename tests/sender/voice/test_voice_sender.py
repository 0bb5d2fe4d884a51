"""Packets of voice: cut at exact times, sent only while somebody talks, in the format that is asked for."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from conf.audio.processing import BLOCK_SAMPLES, VoiceBlock
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples, level_dbfs
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.sender.voice.voice_sender import BLOCK_S, VoiceSender

OPUS = VoiceFormat("opus", 9000, 60, 1, fixed_size=False)
CODEC2 = VoiceFormat("codec2", 3200, 20, 10, fixed_size=True)


@dataclass
class FakeSound:
    """Blocks that were captured, in order; a sample's value is loud for voice."""

    blocks: list[AudioBlock] = field(default_factory=list)
    closed: bool = False

    def add(self, timestamp: float, seconds: float, *, value: int = 8000) -> None:
        self.blocks.append(AudioBlock(timestamp, np.full(round(seconds * SAMPLE_RATE), value, np.int16)))

    def read(self, until: float, /) -> list[AudioBlock]:
        due = [block for block in self.blocks if block.timestamp < until]
        self.blocks = self.blocks[len(due) :]
        return due

    def close(self) -> None:
        self.closed = True


class FakeProcessor:
    """Whatever is loud is voice; the noise is as loud as the newest silence."""

    noise_dbfs = -96.0

    def process(self, block: AudioBlock, /) -> list[VoiceBlock]:
        blocks = []
        for index, samples in enumerate(block.samples.reshape(-1, BLOCK_SAMPLES)):
            active = bool(np.abs(samples).max() > 1000)
            self.noise_dbfs = self.noise_dbfs if active else level_dbfs(samples)
            blocks.append(VoiceBlock(block.timestamp + index * BLOCK_S, samples, active))
        return blocks


class FakeEncoder:
    """A frame's code is its first sample."""

    sample_rate = SAMPLE_RATE

    def __init__(self, frame_ms: int) -> None:
        self.frame_samples = SAMPLE_RATE * frame_ms // 1000

    def encode(self, frame: Samples, /) -> bytes:
        assert len(frame) == self.frame_samples
        return int(frame[0]).to_bytes(2, signed=True)


@dataclass
class FakeOutlet:
    voice_format: VoiceFormat | None = OPUS
    packets: list[VoicePacket] = field(default_factory=list)
    states: list[tuple[VoiceState, int]] = field(default_factory=list)

    def send_voice(self, packet: VoicePacket, now: float, /) -> None:
        self.packets.append(packet)

    def set_voice_state(self, state: VoiceState, now: float, /, *, noise_level: int = 127) -> None:
        self.states.append((state, noise_level))


def make() -> tuple[FakeSound, VoiceSender, FakeOutlet]:
    sound = FakeSound()
    sender = VoiceSender(sound, FakeProcessor(), encoders=lambda codec, rate, frame_ms: FakeEncoder(frame_ms))
    return sound, sender, FakeOutlet()


def test_packets_follow_each_other_without_a_gap() -> None:
    sound, sender, outlet = make()
    for index in range(20):
        sound.add(5.0 + index * 0.02, 0.02, value=8000 + index)
        sender.poll(5.0 + (index + 1) * 0.02, outlet, 0.0)
    assert [packet.timestamp for packet in outlet.packets] == pytest.approx([5.0, 5.06, 5.12, 5.18, 5.24, 5.30])
    values = [int.from_bytes(packet.frames[0], signed=True) for packet in outlet.packets]
    assert values == [8000, 8003, 8006, 8009, 8012, 8015]
    assert all(packet.format == OPUS for packet in outlet.packets)


def test_silence_sends_no_voice_but_its_level() -> None:
    sound, sender, outlet = make()
    sound.add(0.0, 1.2, value=8)
    sender.poll(1.2, outlet, 0.0)
    sound.add(1.2, 0.03, value=8)
    sound.add(1.23, 0.03)
    sound.add(1.26, 0.06, value=0)
    sender.poll(2.0, outlet, 0.0)
    assert [packet.timestamp for packet in outlet.packets] == pytest.approx([1.2])
    states = [state for state, _ in outlet.states]
    assert states[-2:] == [VoiceState.TALKING, VoiceState.SILENT] and set(states[:-2]) == {VoiceState.SILENT}
    assert outlet.states[0][1] == 72  # 8 of 32768 is -72.2 dBFS


def test_a_packet_is_voice_if_any_of_it_is() -> None:
    sound, sender, outlet = make()
    outlet.voice_format = CODEC2
    sound.add(0.0, 0.19, value=0)
    sound.add(0.19, 0.01)
    sender.poll(0.2, outlet, 0.0)
    (packet,) = outlet.packets
    assert len(packet.frames) == 10


def test_a_talk_spurt_begins_20_ms_before_speech_is_noticed() -> None:
    for silent, begin in ((0.11, 0.06), (0.12, 0.06), (0.13, 0.06), (0.14, 0.12), (0.15, 0.12)):
        sound, sender, outlet = make()
        sound.add(0.0, silent, value=0)
        sound.add(silent, 0.1)
        sender.poll(1.0, outlet, 0.0)
        assert outlet.packets[0].timestamp == pytest.approx(begin)


def test_speech_leaves_at_once_and_silence_is_told_at_once() -> None:
    sound, sender, outlet = make()
    sound.add(0.0, 0.06)
    sender.poll(0.06, outlet, 0.0)
    assert len(outlet.packets) == 1
    sound.add(0.06, 0.06, value=0)
    sender.poll(0.12, outlet, 0.0)
    assert outlet.states[-1][0] is VoiceState.SILENT
    sound.add(0.12, 0.02)  # speech after all: the packet before it is sent, too
    sender.poll(0.14, outlet, 0.0)
    assert [packet.timestamp for packet in outlet.packets] == pytest.approx([0.0, 0.06])


def test_it_tells_when_the_next_packet_may_be_complete() -> None:
    sound, sender, outlet = make()
    assert sender.due_in_s == 0.0
    sound.add(0.0, 0.07)
    sender.poll(0.07, outlet, 0.0)
    assert sender.due_in_s == pytest.approx(0.05)
    sound.add(0.07, 0.05)
    sender.poll(0.12, outlet, 0.0)
    assert sender.due_in_s == pytest.approx(0.06)
    sound.add(0.12, 0.06, value=0)
    sender.poll(0.18, outlet, 0.0)
    assert sender.due_in_s == pytest.approx(0.01)  # whether speech follows is known with the next block
    sound.add(0.18, 0.02, value=0)
    sender.poll(0.20, outlet, 0.0)
    assert sender.due_in_s == pytest.approx(0.04)


def test_a_change_of_format_applies_to_the_next_packet() -> None:
    sound, sender, outlet = make()
    sound.add(0.0, 0.1)
    sender.poll(0.1, outlet, 0.0)
    outlet.voice_format = CODEC2
    sound.add(0.1, 0.2)
    sender.poll(0.3, outlet, 0.0)
    assert [(p.timestamp, p.format) for p in outlet.packets] == [(0.0, OPUS), (pytest.approx(0.06), CODEC2)]


def test_without_room_for_voice_it_says_so_and_later_voice_is_fresh() -> None:
    sound, sender, outlet = make()
    outlet.voice_format = None
    sound.add(0.0, 0.5)
    sender.poll(0.5, outlet, 0.0)
    assert outlet.packets == [] and outlet.states[-1][0] is VoiceState.NO_ROOM
    outlet.voice_format = OPUS
    sound.add(0.5, 0.06)
    sender.poll(0.56, outlet, 0.0)
    assert [packet.timestamp for packet in outlet.packets] == pytest.approx([0.5])


def test_a_muted_microphone_sends_nothing() -> None:
    sound, sender, outlet = make()
    sender.muted = True
    sound.add(0.0, 0.3)
    sender.poll(0.3, outlet, 0.0)
    assert outlet.packets == [] and {state for state, _ in outlet.states} == {VoiceState.MUTED}
    assert sender.level_dbfs == pytest.approx(-12.2, abs=0.1)  # the meter still moves


def test_nothing_captured_while_muted_is_sent_afterwards() -> None:
    sound, sender, outlet = make()
    outlet.voice_format = CODEC2  # packets of 200 ms
    sender.muted = True
    sound.add(0.0, 0.15, value=9000)
    sender.poll(0.15, outlet, 0.0)
    sender.muted = False
    sound.add(0.15, 0.2)
    sender.poll(0.35, outlet, 0.0)
    (packet,) = outlet.packets
    assert packet.timestamp == pytest.approx(0.15) and {int.from_bytes(frame) for frame in packet.frames} == {8000}


@pytest.mark.parametrize(("gap", "starts"), [(0.1, [0.0, 0.12, 0.18]), (3.0, [0.0, 3.06, 3.12])])
def test_gaps_are_filled_if_short_and_skipped_if_long(gap: float, starts: list[float]) -> None:
    sound, sender, outlet = make()
    sound.add(0.0, 0.06)
    sender.poll(0.06, outlet, 0.0)
    sound.add(0.06 + gap, 0.12)
    sender.poll(4.0, outlet, 0.0)
    assert [packet.timestamp for packet in outlet.packets] == pytest.approx(starts)


def test_sound_that_overlaps_is_cut() -> None:
    sound, sender, outlet = make()
    sound.add(0.0, 0.06, value=5000)
    sound.add(0.02, 0.1, value=6000)
    sender.poll(1.0, outlet, 0.0)
    assert [packet.timestamp for packet in outlet.packets] == pytest.approx([0.0, 0.06])
    assert int.from_bytes(outlet.packets[1].frames[0], signed=True) == 6000


def test_closing_releases_the_source() -> None:
    sound, sender, _ = make()
    sender.close()
    assert sound.closed
