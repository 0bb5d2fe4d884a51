import pytest

from conf.errors import NetworkError
from conf.transport.fault_tolerance import FaultTolerance

ERROR = NetworkError("nothing can be sent")


def test_a_failure_at_the_start_is_raised_at_once() -> None:
    with pytest.raises(NetworkError, match="nothing can be sent"):
        FaultTolerance(10.0).on_failure(ERROR, 0.0)


def test_a_failure_is_noted_until_the_limit_and_then_raised() -> None:
    faults = FaultTolerance(10.0)
    faults.on_success()
    faults.on_failure(ERROR, 100.0)
    assert faults.note == "nothing can be sent (trying for 10 s more)"
    faults.on_failure(ERROR, 109.0)
    assert faults.note == "nothing can be sent (trying for 1 s more)"
    with pytest.raises(NetworkError):
        faults.on_failure(ERROR, 110.0)


def test_success_ends_the_note_and_starts_the_time_anew() -> None:
    faults = FaultTolerance(5.0)
    faults.on_success()
    faults.on_failure(ERROR, 0.0)
    faults.on_success()
    assert faults.note == ""
    faults.on_failure(ERROR, 6.0)
    faults.on_failure(ERROR, 10.9)
    with pytest.raises(NetworkError):
        faults.on_failure(ERROR, 11.0)


def test_what_has_worked_before_may_fail_at_first() -> None:
    faults = FaultTolerance(10.0, has_worked=True)
    faults.on_failure(ERROR, 0.0)
    assert faults.note.startswith("nothing can be sent")
