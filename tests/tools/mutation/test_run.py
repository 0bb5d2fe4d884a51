"""The score of mutation tests: what is left out, what is counted, which constants are listed."""

import json
from pathlib import Path

import pytest

from tools.mutation import left_out, run

ROW = {"name": "x_f__mutmut_1", "line": "a = b + 1", "changed": "a = b - 1", "survived": False}


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(run, "RESULTS", tmp_path)
    return tmp_path


def test_a_package_stands_for_its_modules() -> None:
    assert run.modules_of("protocol/session/sequence") == ["protocol/session/sequence"]
    assert "sender/motion/extractor" in run.modules_of("sender/motion")
    with pytest.raises(SystemExit, match="conf/protocol/nothing is no module and no package"):
        run.modules_of("protocol/nothing")


@pytest.mark.parametrize(
    ("line", "changed", "reason"),
    [
        ('raise ValueError("n is 0")', "raise ValueError(None)", "the text of an error"),
        ('raise ValueError(f"{n} is 0")', "raise ValueError(None)", "the text of an error"),
        ("raise DatagramError(DropReason.RATE)", "raise DatagramError(None)", ""),
        (
            "zip(a, b, strict=True)",
            "zip(a, b, strict=False)",
            "an internal check: both are equally long by construction",
        ),
        ("zip(a, b, strict=True)", "zip(a, None, strict=True)", ""),
        ("zip(a, b, strict=False)", "zip(a, b, )", "the default"),
        ("a = b + 1", "a = b - 1", ""),
    ],
)
def test_texts_and_internal_checks_are_left_out(line: str, changed: str, reason: str) -> None:
    assert run.left_out_reason("protocol/sequence", line, changed) == reason


def test_every_row_of_the_table_names_a_line_of_its_module() -> None:
    for module, rows in left_out.BY_MODULE.items():
        source = (run.ROOT / "conf" / f"{module}.py").read_text()
        lines = " ".join(line.strip() for line in source.splitlines())
        for part, _, reason in rows:
            assert part in lines, (module, part)
            assert reason


def test_the_report_counts_by_module_and_package(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [ROW, ROW | {"survived": True}, ROW | {"line": 'raise ValueError("n")', "changed": "raise ValueError(None)"}]
    (results / "protocol").mkdir()
    (results / "protocol" / "sequence.json").write_text(json.dumps(rows))
    (results / "protocol" / "wire.json").write_text(json.dumps([ROW, ROW]))
    run.report(["protocol/sequence", "protocol/wire"], survivors=True)
    text = capsys.readouterr().out.splitlines()
    assert text[:3] == ["protocol/sequence x_f__mutmut_1", "  - a = b + 1", "  + a = b - 1"]
    assert [line.split() for line in text[4:]] == [
        ["protocol/sequence", "1", "2", "50.0", "1"],
        ["protocol/wire", "2", "2", "100.0", "0"],
        ["protocol/", "3", "4", "75.0", "1"],
        ["all", "3", "4", "75.0", "1"],
    ]


def test_a_module_without_results_is_named(results: Path) -> None:
    with pytest.raises(SystemExit, match=r"conf/protocol/wire\.py has not been run"):
        run.mutants("protocol/wire")


def test_the_numbers_of_a_module_and_its_classes_are_listed() -> None:
    assert "DERIVATIVE_CUTOFF = 1.0  # Hz, as in the paper" in list(run.constants("sender/motion/one_euro_filter"))
    assert "MIN_RTT_WINDOW_S = 30.0" in list(run.constants("protocol/feedback"))
