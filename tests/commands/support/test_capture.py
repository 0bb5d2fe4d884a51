import argparse
from pathlib import Path

import numpy as np
import pytest

from conf.commands.support.capture import (
    NO_PORTRAIT,
    CaptureOptions,
    add_capture,
    apply_switches,
    has_room_for_portrait,
    open_source,
    rate_options,
    read_code,
    stream_parameters,
)
from conf.errors import CameraError, ConfError
from conf.face.formats.dpc import MotionClip, write_dpc
from conf.protocol.rate_control.rate_levels import VoiceMode


class FakeTerminal:
    """Records what is written; has an answer to a question."""

    def __init__(self, answer: str = "") -> None:
        self.lines: list[str] = []
        self.questions: list[str] = []
        self.answer = answer

    def write(self, text: str, /) -> None:
        self.lines.append(text)

    def ask(self, question: str, /) -> str:
        self.questions.append(question)
        return self.answer


def parsed(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_capture(parser, code_help="the code")
    parser.add_argument("--no-sound", action="store_true")
    return parser.parse_args(arguments)


@pytest.mark.parametrize(
    ("arguments", "kbps", "lines"),
    [
        ((), None, []),
        (("--portrait",), 4.0, []),
        (("--portrait", "--kbps", "2"), 4.0, [NO_PORTRAIT]),
        (("--portrait", "--profile", "narrow"), 4.0, [NO_PORTRAIT]),
        (("--portrait", "--no-portrait"), None, []),
    ],
)
def test_images_are_sent_only_with_the_switch(arguments: tuple[str, ...], kbps: float | None, lines: list[str]) -> None:
    options, terminal = parsed(*arguments), FakeTerminal()
    apply_switches(options, terminal)  # type: ignore[arg-type]
    assert options.portrait_kbps == kbps and terminal.lines == lines


def test_no_sound_switches_the_voice_off() -> None:
    options = parsed("--no-sound")
    apply_switches(options, FakeTerminal())  # type: ignore[arg-type]
    assert options.voice == "off"


@pytest.mark.parametrize(
    ("profile", "kbps", "room"), [("auto", None, True), ("live", 2.9, False), ("narrow", None, False)]
)
def test_a_slow_link_has_no_room_for_images(profile: str, kbps: float | None, room: bool) -> None:
    assert has_room_for_portrait(profile, kbps) is room


def test_the_code_comes_from_the_environment_or_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CONF_CODE", raising=False)
    terminal = FakeTerminal("Acorn tulip river 42")
    assert read_code(terminal, "the receiver") == "acorn-tulip-river-42"  # type: ignore[arg-type]
    assert terminal.questions == ["the code that the receiver shows: "]
    with pytest.raises(ConfError, match="give the one the other end shows with --code"):
        read_code(FakeTerminal(), "the other end")  # type: ignore[arg-type]
    monkeypatch.setenv("CONF_CODE", "amber-canoe-tiger-7")
    assert read_code(FakeTerminal(), "the receiver") == "amber-canoe-tiger-7"  # type: ignore[arg-type]


def test_without_a_voice_its_mode_is_off() -> None:
    options = CaptureOptions(profile="live", kbps=9.0, portrait_kbps=4.0)
    assert rate_options(options, voice=False).voice is VoiceMode.OFF
    rate = rate_options(options, voice=True)
    assert (rate.profile, rate.kbps, rate.portrait_kbps, rate.voice) == ("live", 9.0, 4.0, VoiceMode("auto"))


def test_a_recording_is_opened_without_a_voice(tmp_path: Path) -> None:
    path = tmp_path / "motion.dpc"
    write_dpc(path, MotionClip(10.0, "fapu", np.zeros((20, 50, 3), np.float32), None))
    with open_source(CaptureOptions(dpc=path), None, lambda text: None) as (source, voice):
        assert voice is None and not source.is_live
        parameters = stream_parameters(source)
    assert parameters.fps == 10.0 and parameters.points == 50


def test_a_clip_that_is_missing_is_an_error() -> None:
    options = CaptureOptions(file=Path("nosuch.avi"))
    with pytest.raises(CameraError, match="there is no file"), open_source(options, None, lambda text: None):
        pass
