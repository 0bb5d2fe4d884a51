import argparse
from pathlib import Path

import cv2
import pytest

from conf.commands.receive import ReceiveOptions, add_arguments, receive
from conf.commands.support.display import HEADLESS_SIZE
from conf.errors import ConfError
from conf.sender.capture.clip import open_clip
from conf.transport.udp import UdpSocket

CODE = "amber-canoe-tiger-7"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["call.mp4", "call.avi"])
def test_headless_drawing_writes_a_clip_and_an_image(gl: None, tmp_path: Path, name: str) -> None:
    reports: list[str] = []
    options = ReceiveOptions(tmp_path / name, tmp_path / "call.jpg", seconds=0.5, on_report=reports.append)
    with UdpSocket.bind("127.0.0.1", 0) as link:
        report = receive(link, CODE, options)
    assert report.datagrams == 0 and report.callers == ()
    assert reports == [f"saved {tmp_path / name}", f"saved {tmp_path / 'call.jpg'}"]
    image = cv2.imread(str(tmp_path / "call.jpg"))
    assert image is not None and image.shape[1::-1] == HEADLESS_SIZE
    with open_clip(tmp_path / name) as clip:
        frames = list(iter(clip.read, None))
    assert frames and frames[-1].timestamp < 0.6


@pytest.mark.slow
def test_a_clip_that_cannot_be_written_is_an_error(gl: None, tmp_path: Path) -> None:
    with UdpSocket.bind("127.0.0.1", 0) as link, pytest.raises(ConfError, match="cannot be written"):
        receive(link, CODE, ReceiveOptions(tmp_path / "nowhere" / "call.avi", seconds=0.5))


def test_without_a_host_a_relay_or_the_local_network_is_used() -> None:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    chosen = parser.parse_args(["--relay", "relay.example:99"])
    assert chosen.listen is None and chosen.relay == ("relay.example", 99)
    assert parser.parse_args(["--listen", "5005"]).listen == ("", 5005)
