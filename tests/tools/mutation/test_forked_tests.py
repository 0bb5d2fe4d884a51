"""Mutants of a small module, tested in forks."""

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.slow
def test_the_mutants_of_a_small_module_are_killed_but_the_equivalent_one(tmp_path: Path) -> None:
    pytest.importorskip("mutmut", reason="mutation tests need mutmut: make mutate installs it")
    program = ROOT / "tools" / "mutation" / "forked_tests.py"
    command = [sys.executable, str(program), "protocol/session/sequence", str(tmp_path / "result.json")]
    subprocess.run(command, check=True, capture_output=True)
    rows = json.loads((tmp_path / "result.json").read_text())
    line = "candidate = expected - (expected - low + span // 2) % span + span // 2"
    assert {"line": "span = 1 << bits", "changed": "span = 2 << bits", "survived": False} in [
        {key: row[key] for key in ("line", "changed", "survived")} for row in rows
    ]
    assert [row["changed"] for row in rows if row["survived"]] == [line.replace("low +", "low -")]


def test_a_module_is_tested_by_the_files_that_were_split_off_too() -> None:
    pytest.importorskip("mutmut", reason="mutation tests need mutmut: make mutate installs it")
    forked_tests = importlib.import_module("tools.mutation.forked_tests")
    folder = "tests/protocol"
    assert forked_tests.test_files("protocol/send_leg") == [
        f"{folder}/test_send_leg.py",
        f"{folder}/test_send_leg_voice.py",
    ]
    assert forked_tests.test_files("protocol/sender") == [f"{folder}/test_sender.py"]  # sender_connection has its own
