import pytest

from conf.call.controls import LocalState
from conf.call.link_state import LinkState, Quality
from conf.call.view import UNKNOWN, Waiting, own_notes, remote_notes, status_parts
from conf.protocol.participant.state import CameraState, RemoteState
from conf.protocol.statistics import merge_snapshots
from conf.protocol.voice.formats import VoiceState
from conf.receiver.call_stats import CallStats
from conf.receiver.voice.voice_status import VoiceStatus

STATS = CallStats("receiving", 30.0, merge_snapshots([]))


@pytest.mark.parametrize(
    ("remote", "notes"),
    [
        (RemoteState("Ann", CameraState.ON, VoiceState.TALKING, None), []),
        (RemoteState("Ann", CameraState.OFF, VoiceState.MUTED, None), ["camera off", "muted"]),
        (RemoteState("Ann", CameraState.NO_FACE, VoiceState.SILENT, 40), ["no face seen", "portrait 40 %"]),
        (RemoteState("Ann", CameraState.ON, VoiceState.NO_ROOM, 100), ["no room for voice"]),
        (RemoteState("Ann", CameraState.ON, VoiceState.OFF, 0), ["no microphone", "portrait 0 %"]),
    ],
)
def test_the_state_of_the_other_is_said(remote: RemoteState, notes: list[str]) -> None:
    assert remote_notes(remote, has_voice=True) == notes
    spoken = {"muted", "no room for voice", "no microphone"}
    assert remote_notes(remote, has_voice=False) == [note for note in notes if note not in spoken]


def test_a_photo_that_replaces_another_is_called_better() -> None:
    remote = RemoteState("Ann", CameraState.ON, VoiceState.TALKING, 40)
    assert remote_notes(remote, has_voice=True, shows_photo=True) == ["better portrait 40 %"]


def test_one_s_own_state_is_said() -> None:
    assert own_notes(LocalState(), has_face=True, in_call=True) == []
    assert own_notes(LocalState(), has_face=False, in_call=True) == ["no face seen"]
    assert own_notes(LocalState(), has_face=False, in_call=False) == []
    off = LocalState(camera=False, microphone=False)
    assert own_notes(off, has_face=False, in_call=True) == ["camera off", "muted"]
    assert own_notes(LocalState(has_microphone=False), has_face=True, in_call=True) == ["no microphone"]
    assert own_notes(LocalState(camera_fault="gone"), has_face=False, in_call=True) == ["no camera"]


def texts(link: LinkState, call_s: float | None, stats: CallStats = STATS) -> list[str]:
    return [part.text for part in status_parts(link, "Ann", call_s, stats)]


def test_the_line_says_link_name_and_time() -> None:
    weak = LinkState(Quality.WEAK, "loss 12 %")
    assert texts(weak, 72.0) == ["weak: loss 12 %", "Ann", "1:12", "0.0 kbit/s", "30 fps", "H: keys"]
    assert texts(LinkState(), None) == ["waiting", "H: keys"]
    assert UNKNOWN in [part.text for part in status_parts(weak, "", 1.0, STATS)]


@pytest.mark.parametrize(("muted", "text"), [(True, "sound off"), (False, "voice")])
def test_the_line_says_whether_anything_is_heard(muted: bool, text: str) -> None:
    stats = CallStats("receiving", 30.0, merge_snapshots([]), voice=VoiceStatus(muted=muted))
    assert text in texts(LinkState(Quality.GOOD), 1.0, stats)


def test_that_the_sound_is_off_is_said_before_the_call() -> None:
    stats = CallStats("waiting", 30.0, merge_snapshots([]), voice=VoiceStatus(muted=True))
    assert texts(LinkState(), None, stats) == ["waiting", "sound off", "H: keys"]
    audible = CallStats("waiting", 30.0, merge_snapshots([]), voice=VoiceStatus())
    assert texts(LinkState(), None, audible) == ["waiting", "H: keys"]


def test_while_one_waits_the_code_is_shown_large() -> None:
    notice = Waiting("10.0.0.1:5005", "acorn-tulip-river-42").notice(name="", text="")
    assert notice.title == "waiting for a call at 10.0.0.1:5005" and notice.large == "acorn-tulip-river-42"
    assert notice.lines == ("the other types:  conf call HOST --code acorn-tulip-river-42",)
    again = Waiting("10.0.0.1:5005", "acorn-tulip-river-42").notice(name="Ann", text="Ann has hung up")
    assert again.lines[0] == "Ann has hung up" and again.large


def test_while_one_waits_the_other_s_command_names_this_machine() -> None:
    one = Waiting("port 5005", "acorn-tulip-river-42", hosts=("10.0.0.1",)).notice(name="", text="")
    assert one.title == "waiting for a call at port 5005"
    assert one.lines == ("the other types:  conf call 10.0.0.1 --code acorn-tulip-river-42",)
    hosts = ("10.0.0.1", "fd00::1", "10.1.0.1", "10.2.0.1", "10.3.0.1")
    several = Waiting("port 5005", "acorn-tulip-river-42", hosts=hosts).notice(name="", text="")
    assert several.lines == (*one.lines, "or instead of 10.0.0.1:  fd00::1, 10.1.0.1, 10.2.0.1")


def test_who_calls_sees_whom_and_what_happens() -> None:
    notice = Waiting("10.0.0.1:5005").notice(name="", text="nobody has answered for 5 s")
    assert Waiting("10.0.0.1:5005").state == "calling" and Waiting("10.0.0.1:5005", "acorn-1").state == "waiting"
    line = status_parts(LinkState(), "", None, STATS, idle="calling")
    assert [part.text for part in line] == ["calling", "H: keys"]
    assert (notice.title, notice.large, notice.lines) == ("calling 10.0.0.1:5005", "", ("nobody has answered for 5 s",))
    assert Waiting("10.0.0.1:5005").notice(name="Ann", text="").title == "calling Ann"


def test_over_a_relay_the_code_is_all_that_the_other_types() -> None:
    code = "4711-acorn-tulip-river"
    notice = Waiting("the relay r.example", code, "4711").notice(name="", text="")
    assert notice.large == code and notice.title == "waiting for a call over the relay r.example"
    assert notice.lines == (f"the other types:  conf call {code}",)
    named = Waiting("the relay r.example", code, "4711", relay="r.example:7000").notice(name="", text="Ann has hung up")
    assert named.lines == ("Ann has hung up", f"the other types:  conf call {code} --relay r.example:7000")
    assert (
        Waiting("the local network", "", "4711").notice(name="", text="").title == "calling 4711 over the local network"
    )
