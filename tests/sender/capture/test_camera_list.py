"""Cameras by the kernel's list, or by trying numbers."""

import sys
from pathlib import Path

import pytest

from conf.errors import CameraError
from conf.sender.capture import camera_list
from conf.sender.capture.camera_list import CameraDevice, list_cameras, read_linux_cameras, try_cameras


def add(folder: Path, device: str, **files: str) -> None:
    (folder / device).mkdir()
    for name, text in files.items():
        (folder / device / name).write_text(text)


def test_the_kernels_list_is_sorted_by_number_and_has_no_metadata_devices(tmp_path: Path) -> None:
    add(tmp_path, "video10", name="Capture card\n", index="0\n")
    add(tmp_path, "video2", name="USB camera: Front\n", index="0\n")
    add(tmp_path, "video3", name="USB camera: Front\n", index="1\n")
    add(tmp_path, "video4")
    add(tmp_path, "videodev", name="no number\n")
    assert read_linux_cameras(tmp_path) == (
        CameraDevice(2, "USB camera: Front"),
        CameraDevice(4, "video4"),
        CameraDevice(10, "Capture card"),
    )


def test_no_list_means_no_cameras(tmp_path: Path) -> None:
    assert read_linux_cameras(tmp_path / "missing") == ()


def test_numbers_are_tried_until_one_fails() -> None:
    tried = []

    def describe(number: int) -> str:
        tried.append(number)
        if number == 2:
            raise CameraError("there is no camera 2")
        return "640x480"

    assert try_cameras(describe) == (CameraDevice(0, "640x480"), CameraDevice(1, "640x480"))
    assert tried == [0, 1, 2]


def test_each_system_has_its_way(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    add(tmp_path, "video0", name="Webcam", index="0")
    monkeypatch.setattr(camera_list, "_LINUX_FOLDER", tmp_path)
    monkeypatch.setattr(sys, "platform", "linux")
    assert list_cameras() == (CameraDevice(0, "Webcam"),)
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(camera_list, "_MAX_CAMERAS", 0)
    assert list_cameras() == ()
