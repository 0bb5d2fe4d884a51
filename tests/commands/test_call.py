import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import pytest

from conf.call.figures import CallFigures, SentFigures
from conf.commands.call import (
    BOTH,
    NO_CALL,
    CallOptions,
    _code_to_show,
    add_arguments,
    call,
    figures_text,
    login_name,
    run,
)
from conf.commands.support.capture import CaptureOptions
from conf.commands.support.display import DisplayOptions
from conf.errors import CameraError, ConfError, FileFormatError
from conf.protocol.call_report import CallLog
from conf.sender.capture.clip import open_clip

CODE = "amber-canoe-tiger-7"
ANYWHERE = ("127.0.0.1", 0)


def options(tmp_path: Path, clip: Path, **more: object) -> CallOptions:
    """Return the options of an end that waits for a call and shows a clip."""
    capture = CaptureOptions(file=clip, voice="off")
    display = DisplayOptions(tmp_path / "call.mp4", sound=False)
    return CallOptions(capture, display, None, ANYWHERE, CODE, seconds=0.5, **more)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_call_that_nobody_answers_is_recorded_and_has_no_figures(
    gl: None, tmp_path: Path, short_clip: Path, models: Path
) -> None:
    lines: list[str] = []
    figures = call(options(tmp_path, short_clip, on_ready=lines.append), began=0.0)
    assert len(lines) == 1 and lines[0].startswith("listening on 127.0.0.1:") and lines[0].endswith(f", code {CODE}")
    assert figures.connected_s == 0 and figures.picture_s is None and figures_text(figures) == NO_CALL
    with open_clip(tmp_path / "call.mp4") as written:
        assert written.read() is not None


@pytest.mark.slow
def test_without_a_camera_a_call_is_held_all_the_same(gl: None, tmp_path: Path, models: Path) -> None:
    events: list[str] = []
    display = DisplayOptions(tmp_path / "call.mp4", sound=False, on_event=events.append)
    capture = CaptureOptions(camera="97", voice="off")
    figures = call(CallOptions(capture, display, None, ANYWHERE, CODE, seconds=0.5), began=0.0)
    assert figures.sent.frames_captured == 0
    assert events == ["there is no camera 97: plug one in, name another, or give a clip instead."]


@pytest.mark.parametrize("what", ["clip", "face"])
def test_what_cannot_be_read_is_told_before_the_code(tmp_path: Path, short_clip: Path, what: str) -> None:
    lines: list[str] = []
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(b"no clip")
    face = tmp_path / "face.obj"
    face.write_text("v 0 0 zero\n")
    face.with_suffix(".ppc").write_text("x")
    clip, mesh = (broken, None) if what == "clip" else (short_clip, face)
    with pytest.raises((CameraError, FileFormatError), match=r"broken\.mp4|face\."):
        call(options(tmp_path, clip, face=mesh, on_ready=lines.append), began=0.0)
    assert lines == []


class FakeTerminal:
    """Answers no question."""

    def write(self, text: str, /) -> None: ...

    def ask(self, question: str, /) -> str:
        return ""


def parsed(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return parser.parse_args(arguments)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("4711-acorn-tulip-river", "--listen", "5005"), BOTH),
        (("10.0.0.7", "--listen", "5005"), BOTH),
        (("10.0.0.7",), "give the one the other end shows"),
    ],
)
def test_one_calls_or_is_called(
    arguments: Sequence[str], text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CONF_CODE", raising=False)
    with pytest.raises(ConfError, match=text):
        run(parsed(*arguments, "--headless", str(tmp_path / "a.mp4")), FakeTerminal())  # type: ignore[arg-type]


def test_the_options_are_those_of_send_and_receive() -> None:
    chosen = parsed("10.0.0.7:5006", "--code", CODE, "--file", "a.mp4", "--loop", "--portrait", "--name", "Ann")
    assert chosen.remote == ("10.0.0.7", 5006) and chosen.listen is None and chosen.code == CODE
    assert chosen.file == Path("a.mp4") and chosen.loop and chosen.portrait and chosen.name == "Ann"
    assert parsed("--listen", "5005").listen == ("", 5005)


def test_the_name_is_that_of_the_account(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGNAME", "ann")
    assert login_name() == "ann"

    def fail() -> str:
        raise KeyError("no such user")

    monkeypatch.setattr("conf.commands.call.getpass.getuser", fail)
    assert login_name() == ""


def test_the_figures_tell_both_directions() -> None:
    received = CallLog().report({}, 0.0)
    sent = SentFigures(900, 450, 440, 30_000, 4.0, 8.1, 42.0, 1.5)
    text = figures_text(CallFigures(60.0, 0.5, 0.9, sent, received))
    assert "connected for 60.0 s" in text and "sent      440 frames, 30,000 B, 4.0 kbit/s" in text
    assert "received  0 frames" in text and "round trip 42 ms, loss 1.5 % of what was sent" in text


@pytest.mark.slow
def test_two_processes_hold_a_call(gl: None, tmp_path: Path, short_clip: Path, models: Path) -> None:
    """The only test with sockets: the commands as a user types them."""

    def start(*arguments: str, name: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "conf", "call", *arguments, "--file", str(short_clip), "--loop", "--json"]
        command += ["--headless", str(tmp_path / f"{name}.mp4"), "--code", CODE, "--name", name]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    with start("--listen", "127.0.0.1:0", "--seconds", "60", name="ann") as ann:
        assert ann.stderr is not None
        address = ann.stderr.readline().split()[2].rstrip(",")
        with start(address, "--seconds", "8", name="bob") as bob:
            output, errors = bob.communicate(timeout=120)
            assert bob.returncode == 0, errors
        ann.terminate()
        ann_output, ann_errors = ann.communicate(timeout=120)
        assert ann.returncode == 0, ann_errors
    for text in (output, ann_output):
        figures = json.loads(text)
        assert figures["connected_s"] > 1 and figures["picture_s"] is not None
        assert figures["sent"]["frames_sent"] > 0 and figures["received"]["frames_received"] > 0
    with open_clip(tmp_path / "ann.mp4") as clip:
        frames = [frame.pixels for frame in iter(clip.read, None)]
    assert any((a != b).any() for a, b in pairwise(frames))


def test_who_waits_may_choose_the_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONF_CODE", "Amber canoe tiger 7")
    assert _code_to_show() == CODE
    monkeypatch.setenv("CONF_CODE", "amber")
    with pytest.raises(ConfError, match="CONF_CODE: a code is three words and a number"):
        _code_to_show()
    monkeypatch.delenv("CONF_CODE")
    assert _code_to_show() == ""


def test_the_window_may_be_hidden_until_there_is_a_call() -> None:
    assert parsed("10.0.0.7", "--show-when-connected").show_when_connected
    assert not parsed("10.0.0.7").show_when_connected and DisplayOptions().visible


@pytest.mark.slow
def test_the_first_image_of_a_call_waits_neither_for_scipy_nor_for_pyav() -> None:
    modules = "call.composer, conf.call.loop, conf.face.prepared_face, conf.sender.motion_source, conf.audio.processing"
    check = f"import sys, conf.{modules}, conf.sender.voice.voice_sender; "
    check += "sys.exit(bool({'scipy', 'av'} & sys.modules.keys()))"
    assert subprocess.run([sys.executable, "-P", "-c", check], check=False).returncode == 0
