import argparse
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from conf.audio import devices
from conf.commands.doctor import CHECKS, RELAY_CHECKS, Check, CheckResult, add_arguments, collect, run, run_check
from conf.errors import ConfError
from conf.transport.udp import UdpSocket
from tests.support.relay import router, running_responder

NAMES = [
    "tracker's files",
    "tracker",
    "camera",
    "sound devices",
    "voice codecs",
    "drawing without a display",
    "window",
    "port",
]


def options(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return parser.parse_args(arguments)


def finding(key: str, *arguments: str) -> CheckResult:
    return run_check((CHECKS | RELAY_CHECKS)[key], options(*arguments))


def child(script: str, *, limit_s: float = 60.0) -> CheckResult:
    """Return what is reported of a check whose process runs the script."""
    check = Check("window", lambda _: "", limit_s, "install a driver")
    command = [sys.executable, "-c", script]
    pipe = subprocess.PIPE
    return collect(check, lambda: subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True))


class Terminal:
    """Collects the findings."""

    def __init__(self) -> None:
        self.findings: list[CheckResult] = []
        self.text = ""

    def status_line(self) -> "Terminal":
        return self

    def __enter__(self) -> object:
        return lambda text: None

    def __exit__(self, *_: object) -> None: ...

    def print_list(self, key: str, items: list[CheckResult], text: str) -> None:
        assert key == "findings"
        self.findings, self.text = items, text


def test_a_failed_check_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with UdpSocket.bind("127.0.0.1", 0) as occupied:
        port = finding("port", "--listen", f"127.0.0.1:{occupied.address[1]}")
    assert not port.works and "--listen HOST:PORT" in port.detail
    camera, window = finding("camera", "--camera", "/dev/no-such-camera"), finding("window")
    assert not camera.works and "plug one in" in camera.detail
    assert not window.works and "--headless OUT.mp4" in window.detail


def test_a_successful_check_says_what_was_found(gl: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("conf.sender.tracking.model_files.fetch_models", lambda: tmp_path)
    assert finding("files") == CheckResult("tracker's files", True, str(tmp_path))
    assert finding("offscreen").works
    port = finding("port", "--listen", "127.0.0.1:0")
    assert port.works and port.detail.endswith("is free")


@pytest.mark.slow
def test_the_tracker_check_names_the_backend(models: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    tracker = finding("tracker")
    assert tracker.works and tracker.detail.startswith(("LiteRT ", "OpenCV ")) and "ms a frame" in tracker.detail
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    missing = finding("tracker")
    assert not missing.works and missing.detail.endswith("is missing: run `conf models fetch`.")


@pytest.mark.slow
def test_a_check_that_dies_is_reported_with_its_reason_and_a_remedy() -> None:
    died = child("import sys; print('X Error of failed request:  BadAccess', file=sys.stderr); sys.exit(1)")
    text = "the check ended with status 1 (X Error of failed request:  BadAccess): install a driver"
    assert died == CheckResult("window", False, text)
    assert child("print('[1]')").detail == "the check ended with status 0 (without a message): install a driver"


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="other systems have no signals")
def test_a_check_that_is_killed_names_the_signal() -> None:
    killed = child("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    assert killed.detail == "the check was ended by SIGSEGV (without a message): install a driver"
    realtime = child(f"import os; os.kill(os.getpid(), {signal.SIGRTMIN + 5})")
    assert f"ended by signal {signal.SIGRTMIN + 5} " in realtime.detail


@pytest.mark.slow
def test_a_check_that_hangs_is_ended() -> None:
    assert child("import time; time.sleep(600)", limit_s=0.2) == CheckResult(
        "window", False, "no answer within 0 s: install a driver"
    )


@pytest.mark.slow
def test_all_checks_run_each_in_a_process_of_its_own(
    gl: None, display: str, models: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one process an EGL context before a GLX window ends it: X error BadAccess."""
    monkeypatch.setenv("DISPLAY", display)
    terminal = Terminal()
    run(options("--camera", "/dev/no-such-camera", "--listen", "127.0.0.1:0"), terminal)  # type: ignore[arg-type]
    assert [finding.name for finding in terminal.findings] == NAMES
    failed = {finding.name for finding in terminal.findings if not finding.works}
    assert failed - {"sound devices"} == {"camera"}, terminal.text
    assert (
        terminal.text.startswith("works  tracker's files: ") and "\nFAILS  camera: there is no camera" in terminal.text
    )


@pytest.mark.slow
def test_sound_devices_that_run_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    null = {name: getattr(devices, name) for name in ("open_microphone", "open_speaker")}
    for name, opener in null.items():
        monkeypatch.setattr(devices, name, partial(opener, devices.NULL_DEVICE))
    assert finding("sound") == CheckResult("sound devices", True, "null and null")


def test_missing_sound_devices_are_not_fatal_and_say_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "_find_devices", lambda kind: [])
    text = "there is no microphone here: plug one in, or go on without sound. "
    assert finding("sound") == CheckResult("sound devices", False, text + text.replace("microphone", "speaker").strip())
    monkeypatch.setattr(devices, "open_speaker", partial(devices.open_speaker, devices.NULL_DEVICE))
    assert finding("sound").detail == f"null works, {text}".strip()


def test_voice_names_its_codecs_or_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert finding("voice") == CheckResult("voice codecs", True, "opus, codec2, noise suppression")
    monkeypatch.setitem(sys.modules, "pycodec2.pycodec2", None)
    monkeypatch.setitem(sys.modules, "pywebrtc_audio", None)
    missing = finding("voice")
    assert not missing.works
    assert "pip install pycodec2" in missing.detail and "pip install pywebrtc-audio" in missing.detail


@pytest.mark.slow
def test_the_way_to_a_relay_is_checked_if_one_is_named() -> None:
    with running_responder() as (host, port), router(port):
        arguments = ("--relay", f"{host}:{port}")
        assert finding("relay-udp", *arguments) == CheckResult("relay over UDP", True, f"{host}:{port} carries calls")
        assert finding("relay-tcp", *arguments).works
        assert "there is none" in finding("nat", *arguments).detail


def test_a_check_of_a_relay_needs_its_name() -> None:
    with pytest.raises(ConfError, match="--check nat needs the name of a relay"):
        run(options("--check", "nat"), Terminal())  # type: ignore[arg-type]
