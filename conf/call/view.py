"""What the window of a call says in words. Pure."""

from dataclasses import dataclass

from conf.call.controls import LocalState
from conf.call.link_state import LinkState, Quality
from conf.protocol.participant.state import CameraState, RemoteState
from conf.protocol.voice.formats import VoiceState
from conf.receiver.call_stats import CallStats
from conf.receiver.stats_overlay import SOUND_OFF, STATE_COLOURS, VOICE, WARNING, LinePart, format_bitrate
from conf.render.ui.hud import format_clock
from conf.render.ui.imgui_overlay import MUTED

UNKNOWN = "the other end"
MAX_HOSTS = 4  # addresses of this machine that are listed
QUALITY_COLOURS = {
    Quality.NONE: MUTED,
    Quality.GOOD: STATE_COLOURS["receiving"],
    Quality.WEAK: WARNING,
    Quality.LOST: STATE_COLOURS["lost"],
}
CAMERA_TEXTS = {CameraState.OFF: "camera off", CameraState.NO_FACE: "no face seen"}
VOICE_TEXTS = {VoiceState.OFF: "no microphone", VoiceState.MUTED: "muted", VoiceState.NO_ROOM: "no room for voice"}


@dataclass(frozen=True)
class Notice:
    """What is said in the middle of the window. large : the code, "" for none"""

    title: str
    large: str = ""
    lines: tuple[str, ...] = ()


@dataclass(frozen=True)
class Waiting:
    """What is said while there is no call.

    address : where one listens, or whom one calls, as HOST:PORT; for a call over a relay, what goes between
    code : to be told to the other, "" at the end that calls
    nameplate : of a call over a relay, "" for a direct one
    relay : HOST or HOST:PORT as the other types it, "" in one network
    hosts : at which the other reaches this machine, as it types them; none if that is not known
    """

    address: str
    code: str = ""
    nameplate: str = ""
    relay: str = ""
    hosts: tuple[str, ...] = ()

    @property
    def state(self) -> str:
        """In one word, whether one waits to be called or calls."""
        return "waiting" if self.code else "calling"

    def notice(self, *, name: str, text: str) -> Notice:
        """Return the notice. name : of the last call's other participant, "" before; text : of the last event"""
        lines: tuple[str, ...] = (text,) if text else ()
        if self.code and self.nameplate:
            command = f"conf call {self.code}" + (f" --relay {self.relay}" if self.relay else "")
            lines += (f"the other types:  {command}",)
            return Notice(f"waiting for a call over {self.address}", self.code, lines)
        if self.nameplate:
            return Notice(f"calling {name or self.nameplate} over {self.address}", "", lines)
        if self.code:
            command = f"conf call {self.hosts[0] if self.hosts else 'HOST'} --code {self.code}"
            lines += (f"the other types:  {command}",)
            if others := self.hosts[1:MAX_HOSTS]:
                lines += (f"or instead of {self.hosts[0]}:  {', '.join(others)}",)
            return Notice(f"waiting for a call at {self.address}", self.code, lines)
        return Notice(f"calling {name or self.address}", "", lines)


def remote_notes(remote: RemoteState, *, has_voice: bool, shows_photo: bool = False) -> list[str]:
    """Return what is to be known of the other participant.

    has_voice : whether voice is expected; shows_photo : whether a photo is drawn already, such as the draft
    """
    notes = [CAMERA_TEXTS[remote.camera]] if remote.camera in CAMERA_TEXTS else []
    if has_voice and remote.voice in VOICE_TEXTS:
        notes.append(VOICE_TEXTS[remote.voice])
    if remote.portrait_percent is not None and remote.portrait_percent < 100:
        notes.append(f"{'better portrait' if shows_photo else 'portrait'} {remote.portrait_percent} %")
    return notes


def own_notes(state: LocalState, *, has_face: bool, in_call: bool) -> list[str]:
    """Return what the other sees or hears differently than one may think."""
    notes = []
    if not state.shows_face:
        notes.append("no camera" if state.camera else "camera off")
    elif in_call and not has_face:
        notes.append("no face seen")
    if not state.has_microphone:
        notes.append("no microphone")
    elif not state.microphone:
        notes.append("muted")
    return notes


def status_parts(
    link: LinkState, name: str, call_s: float | None, stats: CallStats, *, path: str = "", idle: str = "waiting"
) -> list[LinePart]:
    """Return the figures of the line.

    call_s : seconds since the call began, None without a call; idle : the state then, in a word
    path : over which it goes, "" if that is not said
    """
    voice, keys = stats.voice, LinePart("H: keys", MUTED, optional=True)
    if call_s is None:
        sound = [LinePart(SOUND_OFF, WARNING)] if voice is not None and voice.muted else []
        return [LinePart(idle, MUTED), *sound, keys]
    parts = [LinePart(link.text, QUALITY_COLOURS[link.quality])]
    parts += [LinePart(name or UNKNOWN, None, optional=True), LinePart(format_clock(call_s), None)]
    if path:
        parts.append(LinePart(path, MUTED, optional=True))
    parts.append(LinePart(format_bitrate(stats.traffic.wire_kbps), MUTED, optional=True))
    parts.append(LinePart(f"{stats.fps:.0f} fps", MUTED, optional=True))
    if voice is not None:
        parts.append(
            LinePart(SOUND_OFF, WARNING) if voice.muted else LinePart(VOICE, MUTED, voice.level, optional=True)
        )
    return [*parts, keys]
