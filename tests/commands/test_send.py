import argparse
from dataclasses import replace
from pathlib import Path

import pytest

from conf.commands.send import SendOptions, _status_text, add_arguments, send
from conf.errors import CameraError, NetworkError
from conf.protocol.send_leg import LinkStatus
from conf.protocol.sender_connection import SenderConnection
from conf.sender.motion_source import TrackedMotionSource
from conf.sender.pipeline import SenderStatus
from conf.transport.udp import UdpSocket

CODE = "amber-canoe-tiger-7"


@pytest.mark.slow
def test_no_reply_is_an_error(short_clip: Path) -> None:
    with (
        UdpSocket.bind("127.0.0.1", 0) as silent,
        pytest.raises(NetworkError, match="nobody answered: start `conf receive` there"),
    ):
        send(silent.address, CODE, SendOptions(file=short_clip, seconds=0.3))


def test_a_missing_clip_is_an_error() -> None:
    with pytest.raises(CameraError, match=r"there is no file nosuch\.avi"):
        send(("127.0.0.1", 9), CODE, SendOptions(file=Path("nosuch.avi")))


def test_an_unknown_host_is_an_error(short_clip: Path) -> None:
    with pytest.raises(NetworkError, match="no address for"):
        send(("no.such.host.invalid", 5005), CODE, SendOptions(file=short_clip))


@pytest.mark.slow
@pytest.mark.parametrize("portrait_kbps", [None, 4.0])
def test_images_are_captured_and_sent_only_if_allowed(
    portrait_kbps: float | None, short_clip: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    created: list[tuple[TrackedMotionSource, SenderConnection]] = []

    class Loop:
        def __init__(
            self, source: TrackedMotionSource, connection: SenderConnection, socket: object, *, voice: object
        ) -> None:
            assert voice is None  # the clip has no sound
            created.append((source, connection))

        def run(self, **options: object) -> None: ...

    monkeypatch.setattr("conf.sender.pipeline.SenderLoop", Loop)
    send(("127.0.0.1", 9), CODE, SendOptions(file=short_clip, portrait_kbps=portrait_kbps))
    ((source, connection),) = created
    assert (source._portrait_scheduler is not None) == (portrait_kbps is not None)
    assert (connection._send._portrait is not None) == (portrait_kbps is not None)


@pytest.mark.parametrize(("voice", "text"), [("muted", "muted"), ("no_room", "no room for voice")])
def test_the_status_line_says_why_no_voice_is_sent(voice: str, text: str) -> None:
    link = LinkStatus(True, False, "voice", 1, None, None, None)
    status = SenderStatus(10, 10, 10, 5.0, 60.0, 8.0, True, True, link, "connected", voice)
    assert f", {text}, tracker" in _status_text(status)
    assert text not in _status_text(replace(status, voice="silent"))


def test_the_status_line_names_the_path_of_a_call_that_began_over_a_relay() -> None:
    link = LinkStatus(True, False, "live", 1, None, None, None)
    status = SenderStatus(10, 10, 10, 5.0, 60.0, 8.0, True, True, link, "connected", "silent", "relay over TCP")
    assert ", relay over TCP, tracker" in _status_text(status, over_relay=True)
    assert "relay" not in _status_text(status)


def test_a_receiver_is_named_by_a_code_its_number_or_a_host() -> None:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    chosen = parser.parse_args(["4711 acorn tulip river", "--relay", "relay.example"])
    assert chosen.receiver == "4711-acorn-tulip-river" and chosen.relay == ("relay.example", 7447)
    assert parser.parse_args(["4711"]).receiver == "4711"
    assert parser.parse_args(["10.0.0.7:5006"]).receiver == ("10.0.0.7", 5006)
