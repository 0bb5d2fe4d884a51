"""Microphones and speakers, by miniaudio: PulseAudio, PipeWire, ALSA, JACK, Core Audio, WASAPI.

Devices run at 48 kHz, their own rate nearly everywhere, and are resampled here: the system's resamplers are often poor.
Their callbacks run in a thread of the library and only copy samples to or from a ring buffer; all else happens in the
thread that calls `read` and `write`. A machine without devices is normal: lists are empty, opening raises AudioError.
"""

import ctypes
import sys
import time
from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import cache
from types import TracebackType
from typing import Any, Self

import numpy as np

from conf.audio.drift import DROPOUT_S, PLAYED_DROPOUT_S, ClockAligner
from conf.audio.resampling import Resampler
from conf.audio.ring_buffer import CaptureBuffer, PlaybackBuffer
from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.errors import AudioError
from conf.thread_priority import raise_thread_priority

NULL_DEVICE = "null"  # the name of a microphone of silence and a speaker that nobody hears, in real time
DEVICE_RATE = 48000
PERIOD_MS = 10  # of a microphone, from callback to callback; 20 delays a voice by 10 ms more
SPEAKER_MS = 20  # the same of a speaker, which keeps two periods ready
# With PulseAudio the library keeps but one period ready and asks for it by quarters: a callback that is later than
# three of them leaves a gap that nobody counts.
PULSE_SPEAKER_MS, PULSE_REQUESTS = 40, 4
SWITCH_INTERVAL_S = 0.001  # for which a callback waits for a thread that computes; Python's default are 5 ms
MISSING = "miniaudio is missing, so there is no sound: type  pip install miniaudio."

_BUFFER_S = 2.0  # capacity of the ring buffers
_MICROPHONE_PERIODS = 20  # in the device's own buffer: what a late callback may leave there
_SPEAKER_PERIODS = 2
_DEAD_AFTER_S = 2.0  # without a callback a device is gone
_CHECK_S = 0.25  # that count between two checks: in a longer time the whole program was stopped, not its device
_ALSA_NULL = "Discard all samples"  # how ALSA names a device on machines that have none
_GAP_S = 0.001
# Of ma_device_config.noFixedSizedCallback from ma_device_config.periods, bytes, in all versions 0.11 of miniaudio: a
# field that its Python module does not have.
_FLAG_OFFSET, _FLAG_VERSION = 11, "0.11."


@dataclass(frozen=True)
class SoundDevice:
    """A microphone or a speaker. number : what options take"""

    number: int
    name: str


def list_microphones() -> tuple[SoundDevice, ...]:
    """Return the microphones of this machine, none if there is no sound system."""
    return tuple(device for device, _ in _find_devices("captures"))


def list_speakers() -> tuple[SoundDevice, ...]:
    """Return the speakers of this machine, none if there is no sound system."""
    return tuple(device for device, _ in _find_devices("playbacks"))


class _Device:
    """An open device whose callbacks stamp a time. name : what the system calls it"""

    def __init__(self, name: str, clock: Callable[[], float]) -> None:
        self.name = name
        self._clock = clock
        self._opened = self._called = clock()  # times of opening and of the last callback
        self._checked = self._opened
        self._silent_s = 0.0
        self._device: Any = None

    def close(self) -> None:
        """Stop and close the device."""
        self._device.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def wait_for_first_callback(self, limit_s: float) -> None:
        """Wait until the device has run. Raises AudioError if it has not after limit_s of real time."""
        deadline = time.monotonic() + limit_s
        while self._called == self._opened:
            if time.monotonic() > deadline:
                raise AudioError(f"{self.name} opens but does not run: close what uses it, or name another device.")
            time.sleep(0.01)

    def _check_alive(self, complaint: str) -> None:
        now = self._clock()
        passed, self._checked = now - max(self._checked, self._called), now
        self._silent_s = min(self._silent_s + min(passed, _CHECK_S), now - self._called)
        if self._silent_s > _DEAD_AFTER_S:
            raise AudioError(f"{self.name} {complaint} any more: plug it in again, or name another device.")


class Microphone(_Device):
    """An open microphone."""

    def __init__(self, name: str, device_id: object, clock: Callable[[], float]) -> None:
        """Use `open_microphone` instead."""
        super().__init__(name, clock)
        self._captured = _ClockedBuffer()
        options = {"input_format": _sample_format(), "callback_periods": _MICROPHONE_PERIODS}
        self._device = _start("CaptureDevice", name, device_id, self._callback(), buffersize_msec=PERIOD_MS, **options)

    def read(self) -> AudioBlock | None:
        """Return what was captured since the last call, at SAMPLE_RATE of the clock, or None; never wait.

        A block's time stamp is the end of the one before, but after a dropout. Raises AudioError if the device is gone.
        """
        block = self._captured.read()
        if block is None:
            self._check_alive("gives no sound")
        return block

    def _callback(self) -> Generator[None, bytearray, None]:
        data = yield
        raise_thread_priority()
        while True:
            samples = np.frombuffer(data, np.int16)
            self._called = self._clock()
            self._captured.write(samples, self._called)
            data = yield


class Speaker(_Device):
    """An open speaker. It plays silence while nothing is written.

    request_s : duration of the sound that it takes at a time; device_latency_s : from a request until the last sample
    of the sound that answers it is heard
    """

    def __init__(self, name: str, device_id: object, clock: Callable[[], float]) -> None:
        """Use `open_speaker` instead."""
        super().__init__(name, clock)
        self._buffer = PlaybackBuffer(round(_BUFFER_S * DEVICE_RATE), rate=DEVICE_RATE)
        self._resampler = Resampler(SAMPLE_RATE, DEVICE_RATE)
        self._played = _ClockedBuffer(dropout_s=PLAYED_DROPOUT_S)
        is_pulse = name != NULL_DEVICE and _has_pulseaudio()
        ready_ms = PULSE_SPEAKER_MS if is_pulse else SPEAKER_MS
        self.request_s = ready_ms / 1000 / (PULSE_REQUESTS if is_pulse else 1)
        self.device_latency_s = self._resampler.delay_s + ready_ms / 1000 * (1 if is_pulse else _SPEAKER_PERIODS)
        options = {"output_format": _sample_format(), "callback_periods": _SPEAKER_PERIODS}
        self._device = _start("PlaybackDevice", name, device_id, self._callback(), buffersize_msec=ready_ms, **options)

    @property
    def queued_s(self) -> float:
        """Return the duration of what was written and has not gone to the device, s."""
        return len(self._buffer) / DEVICE_RATE

    @property
    def next_request_s(self) -> float:
        """Return the time until the device takes sound again, s, 0 if that is overdue."""
        return self.request_s - min(self._clock() - self._called, self.request_s)

    @property
    def latency_s(self) -> float:
        """Return the time until a sample written now is heard, s."""
        return self.queued_s + self.device_latency_s - min(self._clock() - self._called, self.request_s)

    @property
    def underruns(self) -> int:
        """Return how often there was nothing to play after sound had come."""
        return self._buffer.underruns

    def check(self) -> None:
        """Raise AudioError if the device is gone: it takes no sound then, and whoever waits for that writes none."""
        self._check_alive("plays no sound")

    def write(self, samples: Samples, /) -> None:
        """Append samples to what is played; what exceeds two seconds is dropped.

        Raises AudioError if the device is gone.
        """
        self.check()
        self._buffer.write(self._resampler.process(samples))

    def read_played(self) -> AudioBlock | None:
        """Return what the device took since the last call, or None; times are as those of `Microphone.read`.

        It is the reference of echo cancellation. What nobody reads for two seconds is lost.
        """
        return self._played.read()

    def _callback(self) -> Generator[Samples, int, None]:
        count = yield np.zeros(0, np.int16)
        raise_thread_priority()
        while True:
            self._called = self._clock()
            samples = self._buffer.pull(count)
            self._played.write(samples, self._called)
            count = yield samples


class _ClockedBuffer:
    """What one device captured or played, from its callback to SAMPLE_RATE of the clock."""

    def __init__(self, *, dropout_s: float = DROPOUT_S) -> None:
        """dropout_s : as of ClockAligner"""
        self._buffer = CaptureBuffer(round(_BUFFER_S * DEVICE_RATE))
        self._resampler = Resampler(DEVICE_RATE, SAMPLE_RATE)
        self._aligner = ClockAligner(dropout_s=dropout_s)
        self._aligned: deque[AudioBlock] = deque()

    def write(self, samples: Samples, end: float) -> None:
        """Append samples of DEVICE_RATE. end : time of the callback"""
        self._buffer.write_block(samples, end)

    def read(self) -> AudioBlock | None:
        """Return what came since the last call, up to the next dropout, or None."""
        for samples, end in self._buffer.read_blocks():
            start = end - len(samples) / DEVICE_RATE - self._resampler.delay_s
            self._aligned.append(self._aligner.align(AudioBlock(start, self._resampler.process(samples))))
        if not self._aligned:
            return None
        first = self._aligned.popleft()
        parts, end = [first.samples], first.end
        while self._aligned and abs(self._aligned[0].timestamp - end) < _GAP_S:
            block = self._aligned.popleft()
            parts.append(block.samples)
            end = block.end
        return AudioBlock(first.timestamp, np.concatenate(parts))


def open_microphone(name: str | None = None, *, clock: Callable[[], float] = time.monotonic) -> Microphone:
    """Open a microphone and start it.

    name : number, name or part of the name; None is the system's default, NULL_DEVICE silence
    Raises AudioError if there is none or it cannot be opened; the text says what to do.
    """
    found, device_id = _choose("microphone", name, _find_devices("captures"))
    return Microphone(found, device_id, clock)


def open_speaker(name: str | None = None, *, clock: Callable[[], float] = time.monotonic) -> Speaker:
    """Open a speaker and start it. The parameters and errors are those of `open_microphone`."""
    found, device_id = _choose("speaker", name, _find_devices("playbacks"))
    return Speaker(found, device_id, clock)


def _choose(kind: str, name: str | None, devices: list[tuple[SoundDevice, Any]]) -> tuple[str, Any]:
    """Return name and id of the device that a user means."""
    if name == NULL_DEVICE:
        return NULL_DEVICE, None
    if not devices:
        _import_miniaudio()
        raise AudioError(f"there is no {kind} here: plug one in, or go on without sound.")
    if name is None:
        return f"the default {kind}", None
    if name.isdecimal():
        matches = [pair for pair in devices if pair[0].number == int(name)]
    else:
        exact = [pair for pair in devices if pair[0].name == name]
        matches = exact or [pair for pair in devices if name.lower() in pair[0].name.lower()]
    if len(matches) != 1:
        names = ", ".join(f"{device.number} {device.name}" for device, _ in matches or devices)
        problem = f"{kind} {name!r} may be one of several" if matches else f"there is no {kind} {name!r}"
        raise AudioError(f"{problem}: choose from {names}.")
    return matches[0][0].name, matches[0][1]


def _find_devices(kind: str) -> list[tuple[SoundDevice, Any]]:
    """Return the devices with their ids. kind : captures or playbacks"""
    try:
        miniaudio = _import_miniaudio()
    except AudioError:
        return []
    try:
        system = miniaudio.Devices()
        found = getattr(system, f"get_{kind}")()
    except miniaudio.MiniaudioError:
        return []
    if system.backend == "Null":
        return []
    real = [device for device in found if not device["name"].startswith(_ALSA_NULL)]
    return [(SoundDevice(number, device["name"]), device["id"]) for number, device in enumerate(real)]


def _has_pulseaudio() -> bool:
    miniaudio = _import_miniaudio()
    try:
        return str(miniaudio.Devices().backend) == "PulseAudio"
    except miniaudio.MiniaudioError:
        return False


def _sample_format() -> Any:
    return _import_miniaudio().SampleFormat.SIGNED16


def _start(kind: str, name: str, device_id: object, callback: Generator[Any, Any, None], **options: Any) -> Any:
    """Open a device of miniaudio, mono, and start its callbacks."""
    miniaudio = _import_miniaudio()
    if name == NULL_DEVICE:
        options["backends"] = [miniaudio.Backend.NULL]
    next(callback)
    sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL_S))
    try:
        device = _without_fixed_sizes(miniaudio, kind)(
            nchannels=1, sample_rate=DEVICE_RATE, device_id=device_id, app_name="conf", **options
        )
        device.start(callback)
    except miniaudio.MiniaudioError as error:
        raise AudioError(f"{name} cannot be opened ({error}): close what uses it, or name another device.") from error
    return device


def _without_fixed_sizes(miniaudio: Any, kind: str) -> Any:
    """Return a device's class whose callbacks get as much as the system asks for.

    By default the library collects whole periods: sound waits for up to one more, and moves in steps of one.
    """
    base: Any = getattr(miniaudio, kind)
    if not miniaudio.lib_version().startswith(_FLAG_VERSION):
        return base

    class Device(base):  # type: ignore[misc]
        def _make_context(self, *arguments: Any) -> Any:
            flag = miniaudio.ffi.offsetof("ma_device_config", "periods") + _FLAG_OFFSET
            miniaudio.ffi.buffer(miniaudio.ffi.addressof(self._devconfig))[flag : flag + 1] = b"\1"
            return super()._make_context(*arguments)

    return Device


def _import_miniaudio() -> Any:
    try:
        import miniaudio
    except ImportError as error:
        raise AudioError(MISSING) from error
    _silence_alsa()
    return miniaudio


@cache
def _silence_alsa() -> object:
    """Stop ALSA from printing on machines without a card; return its handler, which must not be freed."""
    handler = ctypes.CFUNCTYPE(None)(lambda: None)  # takes none of the arguments: the caller removes them
    if sys.platform == "linux":
        try:
            ctypes.CDLL("libasound.so.2").snd_lib_error_set_handler(handler)
        except (OSError, AttributeError):
            return None  # no ALSA, nothing to silence
    return handler
