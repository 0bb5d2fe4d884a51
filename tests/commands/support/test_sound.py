"""Which sound is captured: the file that was named, the clip's own, a microphone; what is missing is said."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from conf.audio.samples import SAMPLE_RATE, AudioBlock
from conf.commands.support.sound import MuteSwitch, PlayedSound, open_sound
from conf.errors import AudioError, CameraError
from conf.sender.capture.clip import open_clip
from conf.sender.capture.microphone import MicrophoneSource
from conf.sender.capture.sound import FileSoundSource
from conf.sender.voice.voice_sender import VoiceSender
from tests.support.generated_clips import write_clip

TIMES = [i / 25 for i in range(10)]


def test_a_clips_own_sound_is_captured(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "tone.mp4", TIMES, sound_seconds=0.4)
    notes: list[str] = []
    with open_clip(path) as clip:
        sound = open_sound(clip=clip, clip_path=path, on_note=notes.append)
        assert isinstance(sound, FileSoundSource) and notes == []
        samples = np.concatenate([block.samples for block in sound.read(0.3)])
        assert len(samples) == pytest.approx(0.3 * SAMPLE_RATE, abs=2) and np.abs(samples).max() > 5000
        sound.close()


def test_a_silent_clip_has_no_voice_and_nobody_is_told(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "silent.mp4", TIMES)
    notes: list[str] = []
    with open_clip(path) as clip:
        assert open_sound(clip=clip, clip_path=path, on_note=notes.append) is None and notes == []


def test_a_file_takes_the_place_of_the_clips_sound(tmp_path: Path) -> None:
    path = write_clip(tmp_path / "tone.mp4", TIMES, sound_seconds=0.4)
    with pytest.raises(CameraError, match="there is no file"):
        open_sound(clip_path=path, file=tmp_path / "missing.wav", on_note=print)


def test_a_microphone_that_is_not_there_is_an_error_only_if_it_was_named() -> None:
    with pytest.raises(AudioError, match="there is no microphone"):
        open_sound(microphone="no such microphone", on_note=print)
    microphone = open_sound(microphone="null", on_note=print)
    assert isinstance(microphone, MicrophoneSource)
    microphone.close()


def test_without_any_microphone_the_call_goes_on_without_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(device: str | None, *, live_frames: bool) -> None:
        raise AudioError("there is no microphone here: plug one in, or go on without sound.")

    monkeypatch.setattr("conf.sender.capture.microphone.MicrophoneSource", refuse)
    notes: list[str] = []
    assert open_sound(on_note=notes.append) is None
    assert notes == ["no voice is sent: there is no microphone here: plug one in, or go on without sound."]


def test_what_is_played_has_the_times_of_the_frames_once_the_loudspeaker_is_open() -> None:
    played = PlayedSound()
    assert played.read() is None
    blocks = [AudioBlock(50_000.0, np.zeros(160, np.int16)), None]
    played.sound = SimpleNamespace(read_played=lambda: blocks.pop(0))
    played.offset_s = lambda: -49_990.0
    block = played.read()
    assert block is not None and block.timestamp == pytest.approx(10.0) and played.read() is None


def test_a_switch_mutes_the_voice_as_soon_as_there_is_one() -> None:
    switch = MuteSwitch()
    switch.toggle()
    assert not switch.is_muted
    processor = SimpleNamespace(noise_dbfs=-60.0, process=lambda block: [])
    switch.voice = VoiceSender(SimpleNamespace(read=lambda until: [], close=lambda: None), processor)
    switch.toggle()
    assert switch.is_muted and switch.voice.muted
    switch.toggle()
    assert not switch.is_muted
