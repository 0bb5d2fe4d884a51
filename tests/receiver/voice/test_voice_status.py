"""What is shown of the sound: level, who speaks, what is concealed or off, unknown codecs."""

import numpy as np
import pytest

from conf.protocol.voice.formats import VoiceFormat, VoiceFrame, VoiceState
from conf.protocol.voice.inbound import InboundVoice
from conf.receiver.voice.call_sound import ClipSound
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.receiver.voice.voice_status import CONCEALED, REASONS, UnknownCodecs, VoiceStatus, voice_status
from tests.receiver.voice.test_voice_mixer import SilentVoice, Stream

NOW = 1.0


def rendered(streams: dict[int, Stream], seconds: float = 0.5) -> ClipSound:
    mixer = VoiceMixer(streams, np.random.default_rng(3))
    for step in range(round(seconds * 50)):
        mixer.render(step * 0.02, 320)
    return ClipSound(mixer)


def test_without_sound_or_without_a_voice_nothing_is_shown() -> None:
    assert voice_status({1: Stream()}, None, NOW) is None
    assert voice_status({}, rendered({}), NOW) is None


def test_that_the_sound_is_off_is_shown_before_any_voice_has_come() -> None:
    sound = rendered({})
    sound.mixer.muted = True
    status = voice_status({}, sound, NOW)
    assert status is not None and status.muted and not status.notes


def test_a_voice_that_is_concealed_for_more_than_a_tenth_of_a_second_is_noted_for_its_caller() -> None:
    streams = {1: Stream(), 2: Stream(SilentVoice(lost=True))}
    sound = rendered(streams)
    assert sound.mixer.concealing == [2]
    status = voice_status(streams, sound, NOW)
    assert status is not None and status.notes == {2: CONCEALED} and status.note == CONCEALED


@pytest.mark.parametrize(
    ("state", "text"),
    [
        (VoiceState.OFF, "microphone off"),
        (VoiceState.MUTED, "microphone muted"),
        (VoiceState.NO_ROOM, "no room for voice"),
    ],
)
def test_why_no_voice_comes_is_noted_until_it_does(state: VoiceState, text: str) -> None:
    streams = {1: Stream(), 2: Stream()}
    streams[2].voice.state = state
    sound = rendered(streams)
    status = voice_status(streams, sound, NOW)
    assert status is not None and status.notes == {2: text} and status.note == text
    streams[2].voice.state = VoiceState.SILENT
    status = voice_status(streams, sound, NOW)
    assert status is not None and status.notes == {} and status.note == ""


def test_a_caller_who_has_sent_neither_voice_nor_state_for_two_seconds_has_no_microphone() -> None:
    streams = {1: Stream(InboundVoice())}
    sound = rendered(streams)
    assert voice_status(streams, sound, 50.0) is None  # nothing has arrived
    streams[1].clock.on_arrival(0.0, 50.0)
    assert voice_status(streams, sound, 51.9) is None
    status = voice_status(streams, sound, 52.1)
    assert status is not None and status.notes == {1: REASONS[VoiceState.OFF]} and status.level == 0.0
    streams[1].voice.state = VoiceState.SILENT
    assert voice_status(streams, sound, 52.1) is None


def test_mute_and_volume_are_those_of_the_mixer() -> None:
    streams = {1: Stream()}
    sound = rendered(streams)
    sound.mixer.muted = True
    sound.mixer.change_volume(-2)
    status = voice_status(streams, sound, NOW)
    assert status is not None and (status.muted, status.volume_db, status.loudest) == (True, -6.0, None)


@pytest.mark.parametrize(("dbfs", "level"), [(-96.0, 0.0), (-60.0, 0.0), (-30.0, 0.5), (0.0, 1.0), (3.0, 1.0)])
def test_the_meter_reaches_from_minus_60_dbfs_to_full_scale(dbfs: float, level: float) -> None:
    assert VoiceStatus(dbfs).level == pytest.approx(level)


def test_an_unknown_codec_is_said_once_for_each_caller() -> None:
    class FutureVoice(SilentVoice):
        def __init__(self) -> None:
            super().__init__()
            self.format = VoiceFormat("lyra9", 3200, 20, 1, fixed_size=True)

        def frames_until(self, stream_time: float) -> list[VoiceFrame]:
            return [VoiceFrame(stream_time - 0.02, self.format, b"\0" * 8)] if self.format else []

    streams, codecs = {1: Stream(), 2: Stream(FutureVoice())}, UnknownCodecs()
    sound = rendered(streams)
    assert codecs.new(None) == []
    (text,) = codecs.new(sound)
    assert text == "voice in a codec unknown here ('lyra9'): a newer version of conf may know it."
    assert codecs.new(sound) == []
    sound.mixer.participants[1].unknown_codec = text
    assert codecs.new(sound) == [text]
