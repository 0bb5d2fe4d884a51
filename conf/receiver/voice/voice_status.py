"""What the window shows about the sound of a call."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from conf.audio.samples import SILENCE_DBFS
from conf.protocol.voice.formats import VoiceState
from conf.receiver.voice.call_sound import CallSound
from conf.receiver.voice.voice_mixer import VoiceStream

CONCEALED = "voice concealed"
MICROPHONE_OFF = "microphone off"
QUIETEST_DBFS, LOUDEST_DBFS = -60.0, 0.0  # the ends of a level meter


@dataclass(frozen=True)
class VoiceStatus:
    """The sound of the callers who have sent voice.

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
        return next((text for text in (CONCEALED, MICROPHONE_OFF) if text in texts), "")


def voice_status(streams: Mapping[int, VoiceStream], sound: CallSound | None) -> VoiceStatus | None:
    """Return what to show, None if no sound is played or nobody has sent voice."""
    if sound is None:
        return None
    mixer = sound.mixer
    with sound.lock:
        voices, concealing, loudest = dict(mixer.participants), mixer.concealing, mixer.loudest
    if not voices:
        return None
    off = [s for s in voices if s in streams and streams[s].voice.state is VoiceState.OFF]
    notes = dict.fromkeys(off, MICROPHONE_OFF) | dict.fromkeys(concealing, CONCEALED)
    level = max(voice.level_dbfs for voice in voices.values())
    return VoiceStatus(level, mixer.muted, mixer.volume_db, loudest, notes)


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
