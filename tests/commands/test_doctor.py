from pathlib import Path

import pytest

from conf.commands.doctor import run_checks
from conf.transport.udp import UdpSocket


def test_a_failed_check_says_what_to_do(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("conf.sender.tracking.model_files.fetch_models", lambda: tmp_path)
    with UdpSocket.bind("127.0.0.1", 0) as occupied:
        findings = {
            f.name: f for f in run_checks(camera="/dev/no-such-camera", host="127.0.0.1", port=occupied.address[1])
        }
    assert list(findings) == ["tracker's files", "camera", "drawing without a display", "window", "port"]
    assert findings["tracker's files"].works and findings["tracker's files"].detail == str(tmp_path)
    assert not findings["camera"].works and "plug one in" in findings["camera"].detail
    assert not findings["window"].works and "--headless OUT.avi" in findings["window"].detail
    assert not findings["port"].works and "--listen HOST:PORT" in findings["port"].detail


def test_a_successful_check_says_what_was_found(gl: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("conf.sender.tracking.model_files.fetch_models", lambda: tmp_path)
    findings = {f.name: f for f in run_checks(camera="99", host="127.0.0.1", port=0)}
    assert findings["drawing without a display"].works
    assert findings["port"].works and findings["port"].detail.endswith("is free")
