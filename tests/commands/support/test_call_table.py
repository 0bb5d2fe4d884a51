import io

from rich.console import Console

from conf.commands.support.call_table import NO_CALL, call_table
from conf.protocol.call_report import CallLog
from tests.protocol.test_call_report import FIGURES


def printed(log: CallLog, now: float) -> list[list[str]]:
    """Return the words of the table's lines, printed as on a terminal of 80 columns."""
    console = Console(file=io.StringIO(), width=80)
    console.print(call_table(log.report({2: FIGURES}, now)))
    assert isinstance(console.file, io.StringIO)
    return [line.replace("│", " ").split() for line in console.file.getvalue().splitlines()]


def test_each_caller_has_a_row_and_the_last_is_the_total() -> None:
    log = CallLog()
    log.on_connected(1, ("203.0.113.7", 40000), 0.0)
    log.on_ended(1, FIGURES, 20.0)
    log.on_connected(2, ("203.0.113.8", 40000), 90.0)
    rows = [words for words in printed(log, 100.0) if "s" in words]
    assert rows == [
        "203.0.113.7:40000 20.0 s 150 2 7,500 3.0 50.0 60 20".split(),
        "203.0.113.8:40000 10.0 s 150 2 7,500 6.0 50.0 120 20".split(),
        "total 30.0 s 300 4 15,000 4.0 50.0 80 20".split(),
    ]
    caption = "of the bytes: face 20 %, voice 30 %, portrait 10 %, overhead 40 %"
    assert caption.split() in printed(log, 100.0)


def test_without_a_call_it_is_a_sentence() -> None:
    assert call_table(CallLog().report({}, 5.0)) == NO_CALL
