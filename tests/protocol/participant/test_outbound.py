"""Announcements of name and camera: until one is acknowledged, and again when something changes."""

from conf.protocol.messages import ParticipantMessage
from conf.protocol.participant.outbound import KEEP_ALIVE_S, MAX_IN_FLIGHT, REPEAT_S, WAIT_S, OutboundParticipant
from conf.protocol.participant.state import CameraState
from conf.protocol.wire import decode_body

ON, OFF = CameraState.ON, CameraState.OFF


def announced(side: OutboundParticipant, now: float, counter: int = 0) -> ParticipantMessage:
    outgoing = side.body(now)
    assert len(outgoing.body) + 1 == side.max_bytes
    side.on_sent(counter, outgoing)
    body = decode_body(outgoing.body)
    assert isinstance(body, ParticipantMessage)
    return body


def test_without_a_name_nothing_is_announced() -> None:
    side = OutboundParticipant()
    assert not side.is_due(0.0) and not side.is_due_alone(100.0, 0.0)


def test_a_name_is_announced_until_it_is_acknowledged() -> None:
    side = OutboundParticipant("Ada\n")
    side.restart(0.0)
    assert side.is_due(0.0) and not side.is_due_alone(WAIT_S - 0.01, 0.0) and side.is_due_alone(WAIT_S, 0.0)
    assert announced(side, 0.1) == ParticipantMessage("Ada", ON)
    assert not side.is_due(0.1 + REPEAT_S - 0.01) and side.is_due(0.1 + REPEAT_S)
    side.on_acknowledged([7, 3])
    assert side.is_due(1.0)
    side.on_acknowledged([0])
    assert not side.is_due(1.0) and not side.is_due_alone(100.0, 0.0)
    side.restart(2.0)
    assert side.is_due(2.0), "a new session knows nothing"


def test_a_camera_that_is_switched_is_announced_at_once_and_an_older_acknowledgement_does_not_count() -> None:
    side = OutboundParticipant("Ada")
    announced(side, 0.0, counter=5)
    side.set_camera(OFF, 0.1)
    assert side.is_due(0.1)
    side.on_acknowledged([5])
    assert announced(side, 0.1, counter=6) == ParticipantMessage("Ada", OFF)
    side.set_camera(OFF, 0.2)
    assert not side.is_due(0.2)
    side.on_acknowledged([6])
    assert not side.is_due(9.0)
    side.set_camera(ON, 10.0)
    assert side.is_due(10.0) and announced(side, 10.0) == ParticipantMessage("Ada", ON)


def test_while_the_camera_is_off_the_announcement_is_the_keep_alive() -> None:
    side = OutboundParticipant()
    side.set_camera(OFF, 0.0)
    announced(side, 0.0)
    side.on_acknowledged([0])
    assert not side.is_due(9.0)
    assert not side.is_due_alone(9.0, 9.0 - KEEP_ALIVE_S + 0.01) and side.is_due_alone(9.0, 9.0 - KEEP_ALIVE_S)


def test_few_datagrams_are_remembered() -> None:
    side = OutboundParticipant("Ada")
    for counter in range(2 * MAX_IN_FLIGHT):
        announced(side, 0.0, counter)
    assert len(side._in_flight) == MAX_IN_FLIGHT
    side.on_acknowledged([0])
    assert side.is_due(9.0)


def test_a_portrait_that_is_withdrawn_is_announced_until_that_is_acknowledged() -> None:
    side = OutboundParticipant()
    side.set_portrait_withdrawn(True, 0.0)
    assert side.is_due(0.0) and not side.is_due_alone(WAIT_S - 0.01, 0.0) and side.is_due_alone(WAIT_S, 0.0)
    assert announced(side, 0.1, counter=3) == ParticipantMessage("", ON, is_portrait_withdrawn=True)
    side.set_portrait_withdrawn(True, 0.2)
    side.on_acknowledged([3])
    assert not side.is_due(9.0)
    side.set_portrait_withdrawn(False, 10.0)
    assert announced(side, 10.0) == ParticipantMessage("", ON)


def test_a_head_is_announced_without_a_name_too() -> None:
    side = OutboundParticipant(head=3)
    assert side.is_due(0.0) and announced(side, 0.0) == ParticipantMessage("", ON, head=3)
    side.on_acknowledged([0])
    assert not side.is_due(9.0)
