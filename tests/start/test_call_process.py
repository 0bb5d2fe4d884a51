"""The process of a call: its messages, its figures, and why it ended."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from conf.start.call_process import CallProcess

pytestmark = pytest.mark.slow
LIMIT_S = 60.0
ENDLESS = "import signal, sys; print('listening', file=sys.stderr, flush=True); signal.pause()"


@contextmanager
def started(code: str) -> Iterator[tuple[CallProcess, subprocess.Popen[str]]]:
    pipe = subprocess.PIPE
    process = subprocess.Popen([sys.executable, "-c", code], stdout=pipe, stderr=pipe, text=True)
    call = CallProcess(process)
    yield call, process
    call.close()
    assert not call.is_running


def ended(code: str) -> CallProcess:
    with started(code) as (call, process):
        process.wait(LIMIT_S)
        for reader in call._readers:
            reader.join(LIMIT_S)
        text = call.end_text()
    call.end_text = lambda: text  # type: ignore[method-assign]  # before it was closed
    return call


def test_messages_are_read_once_and_figures_at_the_end() -> None:
    call = ended("import sys; print('a\\n\\nb', file=sys.stderr); print('{\"seconds\": 3}')")
    assert call.read_messages() == ["a", "b"] and call.read_messages() == []
    assert call.figures() == {"seconds": 3} and call.end_text() == ""


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("import sys; print('note', file=sys.stderr); sys.exit('conf: nobody answered: check the code')",
         "nobody answered: check the code"),
        ("import sys; print('conf: the settings are ignored', file=sys.stderr); sys.exit('conf: no camera')",
         "no camera"),
        ("import sys; print('Segmentation', file=sys.stderr); sys.exit(3)",
         "the program of the call stopped (exit status 3): Segmentation; `conf doctor` says what"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)",
         f"the program of the call stopped (signal {int(signal.SIGKILL)}); `conf doctor` says"),
    ],
)  # fmt: skip
def test_the_reason_of_an_end_is_one_sentence(code: str, text: str) -> None:
    call = ended(code)
    assert call.end_text().startswith(text) and call.figures() == {}


def test_a_call_that_the_user_ends_has_no_reason() -> None:
    with started(ENDLESS) as (call, process):
        call.hang_up()
        process.wait(LIMIT_S)
        assert call.end_text() == ""


def test_a_process_that_ignores_the_end_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conf.start.call_process.END_S", 0.1)
    with started(f"import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); {ENDLESS}") as (call, process):
        while not call.read_messages():
            assert process.poll() is None
        call.close()
        assert process.returncode == -signal.SIGKILL
    assert call.figures() == {}
