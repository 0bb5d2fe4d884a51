"""The voice's part of a loop: poll a voice sender, and go on without it while its microphone fails."""

from typing import Protocol

from conf.errors import AudioError
from conf.protocol.voice.formats import VoiceState
from conf.sender.voice.voice_sender import VoiceOutlet

VOICE_POLL_S = 0.004  # while a packet may be complete; the frames that wait go with it
IDLE_POLL_S = 0.06  # while no packet can be complete: the duration of a usual one


class Voice(Protocol):
    """A voice sender. due_in_s : seconds after which the next packet may be complete, 0 if there is no telling"""

    @property
    def due_in_s(self) -> float: ...
    def poll(self, until: float, outlet: VoiceOutlet, now: float, /) -> None: ...
    def close(self) -> None: ...


class VoicePoller:
    """Polls the voice when a packet may be complete, at most every VOICE_POLL_S.

    note : why there is no voice now, "" while all is well
    """

    def __init__(self, voice: Voice | None) -> None:
        """voice : the person's, None to send none"""
        self.note = ""
        self._voice = voice
        self._polled_at = float("-inf")
        self._interval_s = VOICE_POLL_S

    def wait_s(self, now: float) -> float:
        """Return the seconds until the next poll, infinite without a voice. Waiting longer delays it."""
        return float("inf") if self._voice is None else max(self._interval_s - (now - self._polled_at), 0.0)

    def poll(self, source_time: float | None, outlet: VoiceOutlet, now: float) -> None:
        """Send the voice packets that are complete, if it is time for it.

        source_time : the time on the clock of the frames, None before the first frame
        """
        if self.wait_s(now) == 0.0:
            self.poll_now(source_time, outlet, now)

    def poll_now(self, source_time: float | None, outlet: VoiceOutlet, now: float) -> None:
        """Send the voice packets that are complete. The frames that wait leave in their datagrams."""
        self._polled_at = now
        if self._voice is None or source_time is None:
            return
        try:
            self._voice.poll(source_time, outlet, now)
        except AudioError as error:
            self.note = str(error)
            outlet.set_voice_state(VoiceState.OFF, now)
        else:
            self.note = ""
            self._interval_s = min(max(self._voice.due_in_s, VOICE_POLL_S), IDLE_POLL_S)
