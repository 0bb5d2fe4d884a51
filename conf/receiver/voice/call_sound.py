"""What the voices of a call go to: a loudspeaker, fed from a thread of its own, or a clip that is being written.

Drawing a frame may take longer than the loudspeaker's sound lasts; therefore the thread.
"""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from types import TracebackType
from typing import Protocol, Self

from conf.audio.samples import SAMPLE_RATE, AudioBlock, Samples
from conf.errors import AudioError
from conf.receiver.voice.voice_mixer import VoiceMixer
from conf.stoppable_thread import StoppableThread
from conf.thread_priority import raise_thread_priority

BLOCK = SAMPLE_RATE // 100  # samples: 10 ms, in multiples of which sound is rendered
RESERVE_S = 0.0125  # of sound beyond the device's next request; more on a machine that keeps this thread waiting
MAX_TARGET_S = 0.24
TARGET_GROWTH = 1.5  # each time that the device ran out of sound
TARGET_DECAY = 0.9997  # with each block of BLOCK samples: half of it is gone after 23 s
POLL_S = 0.005  # while the device's next request is overdue
PACKET_POLL_S = 0.003  # while a voice waits for its next packet
LATEST_S = 0.006  # before the device's next request: until then it waits, and is concealed afterwards
REQUEST_MARGIN_S = 0.002  # from the time of a request until it is looked for
RETRY_S = 2.0  # between two attempts to open a loudspeaker that is gone
MAX_TAPPED = 500  # blocks that wait to be recorded: 5 s
MAX_SKIPPED_S = 1.0  # of sound that a stopped program does not make up for


class CallSound(Protocol):
    """Where the voices of a call go.

    lock : held while the mixer takes frames; whoever changes the streams from another thread holds it meanwhile
    fault : why nothing is heard any more, empty while all is well
    """

    mixer: VoiceMixer
    lock: AbstractContextManager[object]
    fault: str

    def record(self, recording: bool, /) -> None:
        """Start or stop keeping the sound for `recorded`."""
        ...

    def recorded(self, now: float, /) -> list[AudioBlock]:
        """Return the sound up to `now` that was not returned yet; a block's time is when it is heard."""
        ...

    def read_played(self) -> AudioBlock | None:
        """Return what the loudspeaker has played since the last call, None if it has played nothing."""
        ...


class SoundOutput(Protocol):
    """An open loudspeaker.

    queued_s : of what was written and has not gone to the device
    request_s : of what the device takes at a time
    next_request_s : until it takes sound again, 0 if that is overdue
    device_latency_s : from a request until the last sample of the sound that answers it is heard
    latency_s : until a sample written now is heard
    check, write : raise AudioError if the device is gone
    """

    request_s: float
    device_latency_s: float

    @property
    def queued_s(self) -> float: ...
    @property
    def next_request_s(self) -> float: ...
    @property
    def latency_s(self) -> float: ...
    def check(self) -> None: ...
    def write(self, samples: Samples, /) -> None: ...
    def read_played(self) -> AudioBlock | None: ...
    def close(self) -> None: ...


class LoudspeakerSound:
    """Keeps a loudspeaker supplied with the voices of a call.

    fault : why nothing is heard any more, empty while all is well
    """

    def __init__(
        self,
        mixer: VoiceMixer,
        output: SoundOutput,
        *,
        reopen: Callable[[], SoundOutput] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """reopen : opens the loudspeaker again after it was gone, or raises AudioError; None gives it up for good"""
        self.lock: AbstractContextManager[object] = threading.Lock()
        self.mixer = mixer
        self.fault = ""
        self._output = output
        self._reopen = reopen
        self._clock = clock
        self._target_s = self._min_target_s
        self._has_played = self._awaits_packet = False
        self._tapped: deque[AudioBlock] | None = None
        self._thread = StoppableThread(self._run, name="voice")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.stop()
        self._output.close()

    def record(self, recording: bool, /) -> None:
        """Start or stop keeping the sound for `recorded`."""
        self._tapped = deque(maxlen=MAX_TAPPED) if recording else None

    def recorded(self, now: float, /) -> list[AudioBlock]:
        """Return the sound that was kept; a block's time is when it is heard, on the clock of the program."""
        tapped, blocks = self._tapped, []
        while tapped and tapped[0].timestamp < now:
            blocks.append(tapped.popleft())
        return blocks

    def read_played(self) -> AudioBlock | None:
        """Return what the loudspeaker has played since the last call: the reference of echo cancellation."""
        return self._output.read_played()

    def fill(self) -> None:
        """Render until enough sound waits for the device. Raises AudioError if the device is gone.

        A packet that is not there yet is waited for as long as the device needs no sound: what arrives just before its
        time may wait for the thread that receives.
        """
        self._output.check()
        self._awaits_packet = False
        if self._has_played and not self._output.queued_s:
            self._target_s = min(self._target_s * TARGET_GROWTH, MAX_TARGET_S)
        while (missing_s := self._target_s - self._output.queued_s) > 0:
            heard_at = self._clock() + self._output.latency_s
            delay_s = self._output.device_latency_s + self._target_s
            blocks = math.ceil(missing_s * SAMPLE_RATE / BLOCK)  # at once: half of the time goes into the calls
            with self.lock:
                if self._output.next_request_s > LATEST_S and self.mixer.awaits_packet(heard_at, blocks * BLOCK):
                    self._awaits_packet = True
                    return
                samples = self.mixer.render(heard_at, blocks * BLOCK, output_delay_s=delay_s)
            if (tapped := self._tapped) is not None:
                tapped.append(AudioBlock(heard_at, samples))
            self._output.write(self.mixer.audible(samples))
            self._has_played = True
            self._target_s = max(self._target_s * TARGET_DECAY**blocks, self._min_target_s)

    @property
    def wait_s(self) -> float:
        """The seconds until the next `fill`: only a request of the device takes sound."""
        if self.fault:
            return RETRY_S
        if self._awaits_packet:
            return PACKET_POLL_S
        return max(self._output.next_request_s + REQUEST_MARGIN_S, POLL_S)

    @property
    def _min_target_s(self) -> float:
        return self._output.request_s + RESERVE_S

    def _run(self) -> None:
        raise_thread_priority()
        while not self._thread.wait(self.wait_s):
            try:
                if self.fault and self._reopen:
                    output = self._reopen()
                    self._output.close()
                    self._output, self._has_played = output, False
                self.fill()
                self.fault = ""
            except AudioError as error:
                self.fault = self.fault or str(error)
                if self._reopen is None:
                    return


class ClipSound:
    """Renders the voices of a call for a clip, as time passes; nothing is heard."""

    lock: AbstractContextManager[object] = nullcontext()
    fault = ""

    def __init__(self, mixer: VoiceMixer) -> None:
        self.mixer = mixer
        self._heard_until: float | None = None

    def record(self, recording: bool, /) -> None:
        """Do nothing: a clip's sound is always kept."""

    def read_played(self) -> AudioBlock | None:
        """Return None: nothing is heard."""
        return None

    def recorded(self, now: float, /) -> list[AudioBlock]:
        """Return the sound since the last call, up to `now`."""
        if self._heard_until is None or now - self._heard_until > MAX_SKIPPED_S:
            self._heard_until = now
        at = self._heard_until
        count = int((now - at) * SAMPLE_RATE)
        if count <= 0:
            return []
        self._heard_until = at + count / SAMPLE_RATE
        samples = self.mixer.render(at, count)
        return [AudioBlock(at, samples)]
