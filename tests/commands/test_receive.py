from pathlib import Path

import cv2
import pytest

from conf.commands.receive import HEADLESS_FPS, HEADLESS_SIZE, ReceiveOptions, has_display, receive
from conf.errors import ConfError
from conf.transport.udp import UdpSocket

CODE = "amber-canoe-tiger-7"


@pytest.mark.slow
def test_headless_drawing_writes_a_clip_and_an_image(gl: None, tmp_path: Path) -> None:
    options = ReceiveOptions(tmp_path / "call.avi", tmp_path / "call.jpg", seconds=0.5)
    with UdpSocket.bind("127.0.0.1", 0) as link:
        traffic = receive(link, CODE, options)
    assert traffic.datagrams == 0
    image = cv2.imread(str(tmp_path / "call.jpg"))
    assert image is not None and image.shape[1::-1] == HEADLESS_SIZE
    clip = cv2.VideoCapture(str(tmp_path / "call.avi"))
    assert clip.get(cv2.CAP_PROP_FPS) == HEADLESS_FPS and clip.read()[0]


def test_a_clip_that_cannot_be_written_is_an_error(gl: None, tmp_path: Path) -> None:
    with UdpSocket.bind("127.0.0.1", 0) as link, pytest.raises(ConfError, match="cannot be written"):
        receive(link, CODE, ReceiveOptions(tmp_path / "nowhere" / "call.avi", seconds=0.5))


@pytest.mark.parametrize(
    ("variables", "expected"), [({}, False), ({"DISPLAY": ":0"}, True), ({"WAYLAND_DISPLAY": "w"}, True)]
)
def test_a_display_is_detected_by_its_environment_variable(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], expected: bool
) -> None:
    monkeypatch.setattr("conf.commands.receive.os.name", "posix")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert has_display() is expected
