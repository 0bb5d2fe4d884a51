"""The state of a participant as the other end of the call knows it."""

import unicodedata
from dataclasses import dataclass
from enum import Enum

from conf.protocol.voice.formats import VoiceState

MAX_NAME_BYTES = 32  # UTF-8
MAX_HEAD = 63


class CameraState(Enum):
    """What a camera shows."""

    ON = 0
    OFF = 1
    NO_FACE = 2  # on, and nobody in front of it


@dataclass(frozen=True)
class RemoteState:
    """The other participant of a call.

    name : to show as it is, "" if unknown
    portrait_percent : of the photo received, None if none is being sent
    """

    name: str
    camera: CameraState
    voice: VoiceState
    portrait_percent: int | None


def clean_name(name: str, /) -> str:
    """Return a name without characters that draw nothing or change the direction of text, cut to MAX_NAME_BYTES.

    Each run of white space becomes one space. Characters are never cut in two.
    """
    spaced = "".join(" " if character.isspace() else character for character in name)
    visible = "".join(character for character in spaced if unicodedata.category(character)[0] != "C")
    encoded = " ".join(visible.split()).encode("utf-8", errors="ignore")
    return encoded[:MAX_NAME_BYTES].decode("utf-8", errors="ignore").rstrip()
