import json
import sys

import pytest

from tools.network.fuzzer import run_fuzzer


@pytest.mark.parametrize("is_json", [False, True])
def test_the_figures_of_a_fuzzer_are_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], is_json: bool
) -> None:
    monkeypatch.setattr(sys, "argv", ["fuzz", "--datagrams", "20", "--seed", "3", *(["--json"] if is_json else [])])
    run_fuzzer(lambda count, seed: {"datagrams": count, "seed": seed}, "Fuzz.")
    printed = capsys.readouterr().out
    if is_json:
        assert json.loads(printed) == {"datagrams": 20, "seed": 3}
    else:
        assert [line.split() for line in printed.splitlines()] == [["datagrams", "20"], ["seed", "3"]]
