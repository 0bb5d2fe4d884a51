"""All participants' voices as one sound, on the clock of the receiving machine."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from conf.audio.mixer import Mixer
from conf.audio.samples import Samples, to_int16
from conf.protocol.stream_clocks import PlayoutClock
from conf.protocol.voice.inbound import InboundVoice
from conf.receiver.voice.participant_voice import ParticipantVoice

MAX_CONCEALED_S = 0.1  # in a second; more is shown
VOLUME_STEP_DB = 3.0
MIN_VOLUME_DB, MAX_VOLUME_DB = -30.0, 12.0


class VoiceStream(Protocol):
    """The receiving half of a call, as far as its voice is concerned."""

    voice: InboundVoice
    clock: PlayoutClock


class VoiceMixer:
    """Renders the sound of a call.

    muted : nothing is heard, but all is decoded; volume_db : gain of the sound that is heard
    loudest : the session of who speaks, None if nobody does
    """

    def __init__(self, streams: Mapping[int, VoiceStream], rng: np.random.Generator) -> None:
        """streams : by session; participants come and go with it. rng : of the comfort noise"""
        self.muted = False
        self.volume_db = 0.0
        self.loudest: int | None = None
        self.participants: dict[int, ParticipantVoice] = {}
        self._streams = streams
        self._rng = rng
        self._mixer: Mixer[int] = Mixer()

    def change_volume(self, steps: int) -> None:
        """Raise or lower the volume by steps of VOLUME_STEP_DB."""
        self.volume_db = min(max(self.volume_db + steps * VOLUME_STEP_DB, MIN_VOLUME_DB), MAX_VOLUME_DB)

    @property
    def concealing(self) -> list[int]:
        """The sessions of those whose sound is being concealed for more than MAX_CONCEALED_S."""
        return [s for s, voice in self.participants.items() if voice.concealed_s > MAX_CONCEALED_S]

    def render(self, heard_at: float, count: int, *, output_delay_s: float = 0.0) -> Samples:
        """Return the next `count` samples of all voices together, at full volume.

        heard_at : when the first of them will be heard, on the clock on which datagrams arrive, seconds
        output_delay_s : how long before that they are asked for; motion waits as long, to stay in step
        """
        streams = {session: s for session, s in self._streams.items() if s.voice.format is not None}
        for session in self.participants.keys() - streams.keys():
            del self.participants[session]
        sounds = {}
        for session, stream in streams.items():
            if session not in self.participants:
                self.participants[session] = ParticipantVoice(stream.voice, self._rng)
            voice = self.participants[session]
            stream.clock.extra_delay_s = output_delay_s + voice.lookahead_s
            sounds[session] = voice.render(stream.clock.playhead(heard_at), count)
            stream.clock.follow_sound(voice.late_s, heard_at)
        if not sounds:
            self.loudest = None
            return np.zeros(count, np.int16)
        mixed = self._mixer.mix(sounds)
        self.loudest = mixed.loudest
        return mixed.samples

    def awaits_packet(self, heard_at: float, count: int) -> bool:
        """Return whether `render` would begin to conceal somebody's voice that may only be late."""
        return any(
            voice.awaits_packet(self._streams[session].clock.playhead(heard_at), count)
            for session, voice in self.participants.items()
            if session in self._streams
        )

    def audible(self, samples: Samples, /) -> Samples:
        """Return the samples as they are to be heard: at the volume, or muted."""
        if self.muted:
            return np.zeros_like(samples)
        if self.volume_db == 0.0:
            return samples
        return to_int16(samples * 10.0 ** (self.volume_db / 20))
