from types import SimpleNamespace

import pytest

from conf.call.figures import CallTimes, call_figures
from conf.protocol.call_endpoint import CallEndpoint
from tests.support.simulated_call import A, B, Link
from tests.support.simulated_calls import PARAMETERS, talk
from tests.support.simulated_sessions import CODE, seeded

CAPTURE = SimpleNamespace(frames=90, tracked=80, tracker_ms=7.5)


@pytest.mark.slow
def test_both_directions_have_figures() -> None:
    ends = [
        CallEndpoint(code=CODE, parameters=PARAMETERS, now=1000.0, random=seeded(name), remote=remote)
        for name, remote in (("a", None), ("b", A))
    ]
    link = Link({A: ends[0], B: ends[1]})
    link.tick = lambda now: [end.send_frame(talk(now), now) for end in ends]  # type: ignore[func-returns-value, assignment]
    link.run(10)
    first, second = (
        call_figures(end, CAPTURE, CallTimes(999.0, 1000.5, None), link.now)  # type: ignore[arg-type]
        for end in ends
    )
    assert first.name == ""
    assert first.connecting_s == pytest.approx(1.5) and first.picture_s is None
    assert first.sent.frames_captured == 90 and first.sent.frames_tracked == 80 and first.sent.tracker_ms_median == 7.5
    for sender, receiver in ((first, second), (second, first)):
        assert sender.sent.frames_sent == receiver.received.frames_received > 50
        assert receiver.received.wire_kbps == pytest.approx(sender.sent.wire_kbps, rel=0.2)
        assert sender.sent.loss_percent == 0 and sender.sent.round_trip_ms is not None


def test_without_a_call_there_are_no_rates() -> None:
    end = CallEndpoint(code=CODE, parameters=PARAMETERS, now=0.0, random=seeded("a"))
    figures = call_figures(end, CAPTURE, CallTimes(0.0, None, None), 9.0, name="Bea")  # type: ignore[arg-type]
    assert figures.name == "Bea" and figures.connected_s == 0 and figures.connecting_s is None
    assert figures.sent.wire_kbps == 0 and figures.received.callers == ()
