from pathlib import Path

import pytest

from conf.cli import main


def run_models(what: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as exit_:
        main(["models", what])
    assert exit_.value.code == 0
    return capsys.readouterr().out


def test_path_prints_the_folder_of_conf_models(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    assert run_models("path", capsys).strip() == str(tmp_path)


def test_fetch_downloads_and_prints_the_folder(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setenv("CONF_MODELS", str(tmp_path))
    for name in ("fetch_models", "fetch_demo_clip"):
        monkeypatch.setattr(f"conf.sender.tracking.model_files.{name}", lambda show: show("fetching"))
    assert run_models("fetch", capsys).splitlines() == ["fetching"] * 2 + [f"the tracker's files are in {tmp_path}"]
