"""What the window shows about the sound of a call."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from conf.audio.samples import SILENCE_DBFS
from conf.protocol.voice.formats import VoiceState
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_mixer import VoiceStream

CONCEALED = "voice concealed"
REASONS = {  # why there is no voice
    VoiceState.OFF: "microphone off",
    VoiceState.MUTED: "microphone muted",
    VoiceState.NO_ROOM: "no room for voice",
}
START_S = 2.0  # of a stream, for which its first voice or state may be on its way
QUIETEST_DBFS, LOUDEST_DBFS = -60.0, 0.0  # the ends of a level meter


@dataclass(frozen=True)
class VoiceStatus:
    """The sound of the callers.

    level_dbfs : of the loudest voice now, as it arrives; muted, volume_db : what the viewer has chosen
    loudest : session of who speaks, None if nobody does
    notes : by session, what is wrong with a voice or why there is none
    """

    level_dbfs: float = SILENCE_DBFS
    muted: bool = False
    volume_db: float = 0.0
    loudest: int | None = None
    notes: Mapping[int, str] = field(default_factory=dict)

    @property
    def level(self) -> float:
        """The level as a fraction of a meter, 0 to 1."""
        fraction = (self.level_dbfs - QUIETEST_DBFS) / (LOUDEST_DBFS - QUIETEST_DBFS)
        return min(max(fraction, 0.0), 1.0)

    @property
    def note(self) -> str:
        """The most serious of the notes, empty without any."""
        texts = set(self.notes.values())
        return next((text for text in (CONCEALED, *REASONS.values()) if text in texts), "")


def voice_status(streams: Mapping[int, VoiceStream], sound: CallSound | None, now: float) -> VoiceStatus | None:
    """Return what to show, None if no sound is played or there is nothing to say about it."""
    if sound is None:
        return None
    mixer = sound.mixer
    with sound.lock:
        voices, concealing, loudest = dict(mixer.participants), mixer.concealing, mixer.loudest
    known = {s: stream.voice.state for s, stream in streams.items() if s in voices or is_known(stream, now)}
    notes = {session: REASONS[state] for session, state in known.items() if state in REASONS}
    notes |= dict.fromkeys(concealing, CONCEALED)
    if not voices and not notes and not mixer.muted:
        return None
    level = max((voice.level_dbfs for voice in voices.values()), default=SILENCE_DBFS)
    return VoiceStatus(level, mixer.muted, mixer.volume_db, loudest, notes)


def is_known(stream: VoiceStream, now: float) -> bool:
    """Return whether a stream's voice state is known: without a message for a while, there is no microphone."""
    return stream.voice.state is not VoiceState.OFF or (
        stream.clock.has_started and stream.clock.playhead(now) > START_S
    )


class UnknownCodecs:
    """Says once of each caller that its voice cannot be decoded here."""

    def __init__(self) -> None:
        self._reported: set[int] = set()

    def new(self, sound: CallSound | None) -> list[str]:
        """Return what is wrong with the voices of which nothing was returned before."""
        if sound is None:
            return []
        with sound.lock:
            faults = {s: voice.unknown_codec for s, voice in sound.mixer.participants.items() if voice.unknown_codec}
            self._reported &= sound.mixer.participants.keys()
        texts = [text for session, text in faults.items() if session not in self._reported]
        self._reported |= faults.keys()
        return texts
