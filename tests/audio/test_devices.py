"""Sound devices: lists, choice by number and name, and real time with miniaudio's Null backend."""

import sys
import time
from collections.abc import Callable
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from conf.audio import devices
from conf.audio.devices import (
    DEVICE_RATE,
    MISSING,
    NULL_DEVICE,
    PERIOD_MS,
    PULSE_SPEAKER_MS,
    SPEAKER_MS,
    SoundDevice,
    list_microphones,
    list_speakers,
    open_microphone,
    open_speaker,
)
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.errors import AudioError
from tests.support.synthetic_voice import tone

miniaudio = pytest.importorskip("miniaudio")
PERIOD = DEVICE_RATE * PERIOD_MS // 1000


class Clock:
    """A clock that tests set."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


class Opened:
    """A device of the library that a test drives by hand."""

    def __init__(self, **options: Any) -> None:
        self.options = options
        self.closed = False

    def start(self, callback: Any) -> None:
        self.callback = callback

    def close(self) -> None:
        self.closed = True


def stub(monkeypatch: pytest.MonkeyPatch, **names: Any) -> None:
    """Replace miniaudio by one with two microphones and three speakers."""

    class Devices:
        backend = "PulseAudio"

        def get_captures(self) -> list[dict[str, str]]:
            return [{"name": "Headset", "id": "a"}, {"name": "Webcam microphone", "id": "b"}]

        def get_playbacks(self) -> list[dict[str, str]]:
            return [{"name": name, "id": name} for name in ("HDMI 1", "HDMI 2", "HDMI")]

    library = {"Devices": Devices, "CaptureDevice": Opened, "PlaybackDevice": Opened, "lib_version": lambda: "0.12.0"}
    for name in ("SampleFormat", "Backend", "MiniaudioError"):
        library[name] = getattr(miniaudio, name)
    monkeypatch.setitem(sys.modules, "miniaudio", SimpleNamespace(**(library | names)))


def raising(*_: Any, **__: Any) -> Any:
    raise miniaudio.MiniaudioError("failed to init device", -301)


def test_devices_are_numbered(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    assert list_microphones() == (SoundDevice(0, "Headset"), SoundDevice(1, "Webcam microphone"))
    assert [device.name for device in list_speakers()] == ["HDMI 1", "HDMI 2", "HDMI"]


@pytest.mark.parametrize(
    ("name", "expected"), [(None, None), ("1", "b"), ("Headset", "a"), ("webcam", "b"), ("NULL", None)]
)
def test_a_microphone_is_chosen_by_number_name_or_part_of_it(
    name: str | None, expected: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    stub(monkeypatch)
    if name == "NULL":
        name = NULL_DEVICE
    with open_microphone(name) as microphone:
        opened = microphone._device
        assert opened.options["device_id"] == expected
        assert (opened.options.get("backends") is not None) == (name == NULL_DEVICE)
    assert opened.closed


def test_an_exact_name_wins_over_longer_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    assert open_speaker("HDMI").name == "HDMI"


@pytest.mark.parametrize(
    ("opener", "name", "message"),
    [
        (open_microphone, "7", "there is no microphone '7': choose from 0 Headset, 1 Webcam microphone."),
        (open_microphone, "radio", "there is no microphone 'radio': choose from 0 Headset, 1 Webcam microphone."),
        (open_speaker, "hdmi", "speaker 'hdmi' may be one of several: choose from 0 HDMI 1, 1 HDMI 2, 2 HDMI."),
    ],
)
def test_a_wrong_name_is_answered_with_the_right_ones(
    opener: Callable[[str], object], name: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stub(monkeypatch)
    with pytest.raises(AudioError) as error:
        opener(name)
    assert str(error.value) == message


@pytest.mark.parametrize(
    "library",
    [
        {"Devices": raising},
        {"Devices": lambda: SimpleNamespace(backend="ALSA", get_captures=raising, get_playbacks=raising)},
        {"Devices": lambda: SimpleNamespace(backend="Null", get_captures=list, get_playbacks=list)},
        {
            "Devices": lambda: SimpleNamespace(
                backend="ALSA",
                get_captures=lambda: [{"name": "Discard all samples (playback) or generate zero samples", "id": 1}],
                get_playbacks=list,
            )
        },
    ],
)
def test_a_machine_without_devices(library: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch, **library)
    assert list_microphones() == list_speakers() == ()
    with pytest.raises(AudioError, match="there is no microphone here: plug one in, or go on without sound"):
        open_microphone()
    with pytest.raises(AudioError, match="there is no speaker here: plug one in, or go on without sound"):
        open_speaker("0")


def test_a_device_in_use_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch, CaptureDevice=raising)
    with pytest.raises(AudioError, match=r"Headset cannot be opened \(.*failed to init device.*\): close what uses it"):
        open_microphone("0")


def test_without_the_library_lists_are_empty_and_opening_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "miniaudio", None)
    assert list_microphones() == list_speakers() == ()
    for opener in (open_microphone, open_speaker):
        with pytest.raises(AudioError) as error:
            opener(None)
        assert str(error.value) == MISSING


def test_captured_sound_comes_with_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    clock = Clock()
    microphone = open_microphone(clock=clock)
    assert microphone.read() is None
    sound = np.rint(9000 * np.sin(2 * np.pi * 500 * np.arange(10 * PERIOD) / DEVICE_RATE)).astype(np.int16)
    blocks = []
    for i in range(10):
        clock.now = 100 + (i + 1) * PERIOD_MS / 1000
        microphone._device.callback.send(bytearray(sound[i * PERIOD : (i + 1) * PERIOD].tobytes()))
        if i % 3 == 0:
            blocks.append(microphone.read())
    for before, after in pairwise(blocks):
        assert before is not None and after is not None
        assert after.timestamp == pytest.approx(before.end, abs=1e-9)
    assert blocks[1] is not None and len(blocks[1].samples) == 3 * SAMPLE_RATE * PERIOD_MS // 1000
    times = blocks[1].timestamp - 100 + np.arange(len(blocks[1].samples)) / SAMPLE_RATE
    expected = 9000 * np.sin(2 * np.pi * 500 * times)
    assert np.abs(blocks[1].samples - expected).max() < 60


def test_after_a_dropout_the_gap_is_left_between_two_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    clock, blocks = Clock(), list[AudioBlock]()
    microphone = open_microphone(clock=clock)
    for i in [*range(200), *range(220, 400)]:  # 200 ms missing
        clock.now = 100 + (i + 1) * PERIOD_MS / 1000
        microphone._device.callback.send(bytearray(2 * PERIOD))
        if i % 80 == 79:
            while (block := microphone.read()) is not None:
                blocks.append(block)
    gaps = [after.timestamp - before.end for before, after in pairwise(blocks)]
    assert max(gaps) == pytest.approx(0.2, abs=0.002)
    assert sorted(gaps)[-2] < 1e-9


def test_a_device_that_never_runs_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    clock = Clock()
    microphone = open_microphone("headset", clock=clock)
    with pytest.raises(AudioError, match="Headset opens but does not run: close what uses it, or name another device"):
        microphone.wait_for_first_callback(0.0)
    clock.now += 1
    microphone._device.callback.send(bytearray(2 * PERIOD))
    microphone.wait_for_first_callback(0.0)


def test_a_microphone_that_falls_silent_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    clock = Clock()
    microphone = open_microphone("webcam", clock=clock)
    for _ in range(19):
        clock.now += 0.1
        assert microphone.read() is None
    clock.now += 0.2
    with pytest.raises(AudioError, match="Webcam microphone gives no sound any more: plug it in again, or name"):
        microphone.read()


def pull(speaker: devices.Speaker, periods: int, clock: Clock) -> Samples:
    parts = []
    for _ in range(periods):
        clock.now += PERIOD_MS / 1000
        parts.append(speaker._device.callback.send(PERIOD))
    return np.concatenate(parts)


def test_written_sound_is_played_after_the_latency_and_kept_for_echo_cancellation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stub(monkeypatch)
    clock = Clock()
    speaker = open_speaker("HDMI 2", clock=clock)
    assert not pull(speaker, 2, clock).any()
    speaker.write(tone(500, 0.2))
    assert speaker.queued_s == pytest.approx(0.2)
    assert speaker.latency_s == pytest.approx(0.2 + 0.001 + PULSE_SPEAKER_MS / 1000)
    assert speaker.next_request_s == pytest.approx(speaker.request_s)
    clock.now += 0.004  # time passes, and the device asks for nothing yet
    assert speaker.next_request_s == pytest.approx(speaker.request_s - 0.004)
    assert speaker.latency_s == pytest.approx(0.2 + 0.001 + PULSE_SPEAKER_MS / 1000 - 0.004)
    clock.now -= 0.004
    played = pull(speaker, 20, clock)
    assert speaker.queued_s == 0 and speaker.underruns == 0
    times = np.arange(len(played)) / DEVICE_RATE - 0.001
    expected = 8000 * np.sin(2 * np.pi * 500 * times)
    assert np.abs(played - expected)[480:].max() < 60  # after the fade
    reference = speaker.read_played()
    assert reference is not None
    assert len(reference.samples) == SAMPLE_RATE * 22 * PERIOD_MS // 1000
    assert reference.end == pytest.approx(clock.now, abs=0.002)  # the delay of two resamplers
    assert speaker.read_played() is None
    pull(speaker, 1, clock)
    assert speaker.underruns == 1


@pytest.mark.parametrize(
    ("backend", "name", "period_ms", "request_ms", "latency_ms"),
    [
        ("PulseAudio", "HDMI 2", PULSE_SPEAKER_MS, PULSE_SPEAKER_MS / 4, PULSE_SPEAKER_MS),
        ("PulseAudio", NULL_DEVICE, SPEAKER_MS, SPEAKER_MS, 2 * SPEAKER_MS),
        ("ALSA", "HDMI", SPEAKER_MS, SPEAKER_MS, 2 * SPEAKER_MS),
    ],
)
def test_pulseaudio_is_asked_for_more_as_it_keeps_one_period_only(
    backend: str, name: str, period_ms: int, request_ms: float, latency_ms: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    stub(monkeypatch)
    monkeypatch.setattr(sys.modules["miniaudio"].Devices, "backend", backend)
    speaker = open_speaker(name, clock=Clock())
    assert speaker._device.options["buffersize_msec"] == period_ms
    assert speaker.request_s == pytest.approx(request_ms / 1000)
    assert speaker.latency_s == speaker.device_latency_s == pytest.approx(0.001 + latency_ms / 1000)
    assert open_microphone("0", clock=Clock())._device.options["buffersize_msec"] == PERIOD_MS


def test_a_speaker_that_stops_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    clock = Clock()
    speaker = open_speaker(clock=clock)
    for _ in range(20):
        clock.now += 0.1
        speaker.check()
    clock.now += 0.1
    with pytest.raises(AudioError, match="the default speaker plays no sound any more: plug it in again"):
        speaker.write(tone(500, 0.1))


def test_a_speaker_outlives_a_program_that_was_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    stub(monkeypatch)
    clock = Clock()
    speaker = open_speaker(clock=clock)
    for _ in range(10):
        clock.now += 60.0  # a laptop that slept
        speaker.check()
        pull(speaker, 1, clock)
        speaker.check()


@pytest.mark.slow
def test_the_null_device_runs_in_real_time() -> None:
    with open_microphone(NULL_DEVICE) as microphone, open_speaker(NULL_DEVICE) as speaker:
        speaker.write(tone(440, 0.2))
        blocks: list[AudioBlock] = []
        deadline = time.monotonic() + 20
        while (speaker.queued_s or len(blocks) < 5) and time.monotonic() < deadline:
            block = microphone.read()
            blocks += [block] if block is not None else []
            time.sleep(0.005)
        assert speaker.queued_s == 0
        assert not np.concatenate([block.samples for block in blocks]).any()
        assert blocks[-1].end <= time.monotonic()
        played = speaker.read_played()
        assert played is not None and played.end <= time.monotonic()


@pytest.mark.slow
def test_listing_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    list_microphones()
    list_speakers()
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_real_lists_never_raise() -> None:
    assert [device.number for device in list_microphones()] == list(range(len(list_microphones())))
    assert [device.number for device in list_speakers()] == list(range(len(list_speakers())))


@pytest.mark.parametrize("kind", ["CaptureDevice", "PlaybackDevice"])
def test_callbacks_get_what_the_system_asks_for(kind: str) -> None:
    made: list[bytes] = []

    class Base:
        _devconfig = miniaudio.lib.ma_device_config_init(miniaudio.lib.ma_device_type_playback)

        def _make_context(self, name: str) -> str:
            made.append(bytes(miniaudio.ffi.buffer(miniaudio.ffi.addressof(self._devconfig))))
            return name

    before = bytes(miniaudio.ffi.buffer(miniaudio.ffi.addressof(Base._devconfig)))
    library = SimpleNamespace(lib_version=miniaudio.lib_version, ffi=miniaudio.ffi, **{kind: Base})
    assert devices._without_fixed_sizes(library, kind)()._make_context("x") == "x"
    changed = [index for index, (old, new) in enumerate(zip(before, made[0], strict=True)) if old != new]
    # the fourth of the flags behind ma_device_config.performanceProfile, the last before the callbacks
    assert changed == [miniaudio.ffi.offsetof("ma_device_config", "dataCallback") // 8 * 8 - 5]
    assert made[0][changed[0]] == 1
