from pathlib import Path

import cv2
import pytest

from conf.commands.receive import HEADLESS_FPS, SIZE, ReceiveOptions, has_display, receive
from conf.errors import ConfError
from conf.transport.udp import UdpSocket

CODE = "amber-canoe-tiger-7"


def test_without_a_display_it_draws_into_a_clip_and_a_picture(gl: None, tmp_path: Path) -> None:
    showing = ReceiveOptions(tmp_path / "call.avi", tmp_path / "call.jpg", seconds=0.5)
    with UdpSocket.bind("127.0.0.1", 0) as link:
        traffic = receive(link, CODE, showing)
    assert traffic.datagrams == 0
    assert cv2.imread(str(tmp_path / "call.jpg")).shape[1::-1] == SIZE
    film = cv2.VideoCapture(str(tmp_path / "call.avi"))
    assert film.get(cv2.CAP_PROP_FPS) == HEADLESS_FPS and film.read()[0]


def test_a_clip_that_cannot_be_written_is_said_at_once(gl: None, tmp_path: Path) -> None:
    with UdpSocket.bind("127.0.0.1", 0) as link, pytest.raises(ConfError, match="cannot be written"):
        receive(link, CODE, ReceiveOptions(tmp_path / "nowhere" / "call.avi", seconds=0.5))


@pytest.mark.parametrize(
    ("variables", "there"), [({}, False), ({"DISPLAY": ":0"}, True), ({"WAYLAND_DISPLAY": "w"}, True)]
)
def test_a_display_is_known_by_its_name(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], there: bool
) -> None:
    monkeypatch.setattr("conf.commands.receive.os.name", "posix")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert has_display() is there
