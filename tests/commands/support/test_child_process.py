import json
from pathlib import Path

import pytest

from conf.commands.support.child_process import start_conf

pytestmark = pytest.mark.slow


def test_a_file_of_the_same_name_in_the_working_folder_is_not_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "conf.py").write_text("raise SystemExit('this is the configuration of some documentation')")
    monkeypatch.chdir(tmp_path)
    with start_conf(["doctor", "--check", "port", "--listen", "127.0.0.1:0", "--json"]) as process:
        output, errors = process.communicate(timeout=60)
    assert json.loads(output)["findings"][0]["name"] == "port" and not errors


def test_variables_reach_the_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with start_conf(["models", "path"], environment={"CONF_MODELS": str(tmp_path / "nowhere")}) as process:
        output, _ = process.communicate(timeout=60)
    assert output.strip() == str(tmp_path / "nowhere")
