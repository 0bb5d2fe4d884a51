from pathlib import Path

import cv2
import pytest

from conf.commands.receive import HEADLESS_SIZE, ReceiveOptions, check_before_call, has_display, receive
from conf.errors import ConfError, FileFormatError, GraphicsError
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


@pytest.mark.parametrize(
    ("platform", "variables", "expected"),
    [
        ("linux", {}, False),
        ("linux", {"DISPLAY": ":0"}, True),
        ("linux", {"WAYLAND_DISPLAY": "w"}, True),
        ("darwin", {}, True),
        ("win32", {}, True),
    ],
)
def test_a_display_is_detected_by_its_environment_variable(
    monkeypatch: pytest.MonkeyPatch, platform: str, variables: dict[str, str], expected: bool
) -> None:
    monkeypatch.setattr("conf.commands.receive.sys.platform", platform)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert has_display() is expected


def test_what_cannot_be_shown_is_told_before_the_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"nope\.obj: expected a file; check the name"):
        check_before_call(tmp_path / "nope.obj", None)
    face = tmp_path / "face.obj"
    face.touch()
    with pytest.raises(FileFormatError, match=r"face\.ppc: expected a file; `conf fit .*face\.obj` makes it"):
        check_before_call(face, None)
    face.with_suffix(".ppc").touch()
    monkeypatch.setattr("conf.commands.receive.has_display", lambda: False)
    check_before_call(face, tmp_path / "call.avi")
    with pytest.raises(GraphicsError, match="no window can be opened: there is no display"):
        check_before_call(face, None)


@pytest.mark.parametrize(
    ("name", "message"),
    [("call.mov", "must end in .mp4 or .avi"), ("none/call.mp4", "cannot be written"), ("call", "must end in")],
)
def test_a_clip_is_checked_before_the_call(tmp_path: Path, name: str, message: str) -> None:
    with pytest.raises(ConfError, match=message):
        check_before_call(None, tmp_path / name)
    check_before_call(None, tmp_path / "call.mp4")
    assert not list(tmp_path.iterdir())
