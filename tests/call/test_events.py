import pytest

from conf.call.events import describe_event
from conf.errors import NetworkError
from conf.protocol.address import RelayAddress
from conf.protocol.session.events import (
    AddressChanged,
    BodyReceived,
    Connected,
    Event,
    LossReason,
    NoAnswer,
    Refused,
    SessionEnded,
    WrongCode,
)
from conf.protocol.session.handshake import Refusal

THERE = ("10.0.0.7", 5005)


@pytest.mark.parametrize(
    ("event", "name", "text"),
    [
        (Connected(1, THERE), "", "connected with 10.0.0.7"),
        (Connected(1, THERE), "Ann", "connected with Ann"),
        (AddressChanged(1, THERE), "Ann", "Ann has moved to 10.0.0.7"),
        (AddressChanged(1, THERE), "", "the other end has moved to 10.0.0.7"),
        (SessionEnded(1, LossReason.HUNG_UP), "Ann", "Ann has hung up"),
        (SessionEnded(1, LossReason.IDLE), "", "the other end has not been heard for 30 s: the call is over"),
        (SessionEnded(1, LossReason.REPLACED), "Ann", ""),
        (SessionEnded(1, LossReason.CLOSED), "Ann", ""),
        (BodyReceived(1, b"", THERE, 0), "Ann", ""),
        (
            NoAnswer(5.2),
            "",
            "nobody has answered for 5 s: is `conf call --listen` running there, of the same version? trying on",
        ),
        (Refused(Refusal.IN_CALL, 3.0), "", "the other end is in a call: trying again in 3 s"),
        (Refused(Refusal.LOCKED, 12.0), "", "too many wrong codes: the other end listens again in 12 s"),
        (Refused(Refusal.LOCKED, 255), "", "too many wrong codes: the other end listens again in 255 s"),
    ],
)
def test_events_have_a_sentence(event: Event, name: str, text: str) -> None:
    assert describe_event(event, name=name, is_calling=True) == text


def test_a_wrong_code_ends_the_call_of_who_calls_only() -> None:
    event = WrongCode(4, THERE)
    with pytest.raises(NetworkError, match="the code is wrong: type it as the other end shows it"):
        describe_event(event, name="", is_calling=True)
    assert describe_event(event, name="", is_calling=False) == "a wrong code from 10.0.0.7: 4 more tries for now"


def test_a_refusal_for_good_is_an_error() -> None:
    with pytest.raises(NetworkError, match="the other end is in a call: try later"):
        describe_event(Refused(Refusal.FULL, None), name="", is_calling=True)


def test_every_refusal_and_every_reason_has_a_text() -> None:
    for refusal in set(Refusal) - {Refusal.WRONG_CODE}:
        assert describe_event(Refused(refusal, 2.0), name="", is_calling=True)
    for reason in LossReason:
        describe_event(SessionEnded(1, reason), name="Ann", is_calling=True)


def over_relay(event: Event, *, is_awaited: bool = True) -> str:
    return describe_event(event, name="", is_calling=True, nameplate="4711", is_awaited=is_awaited)


def test_a_call_over_a_relay_names_its_path_and_its_number() -> None:
    relay = RelayAddress("4711", "")
    assert over_relay(Connected(1, relay)) == "connected with the other end"
    assert over_relay(AddressChanged(1, ("192.0.2.1", 5005))) == "the call goes directly now"
    assert over_relay(AddressChanged(1, relay)) == "the direct path has failed: the call goes over the relay"
    assert over_relay(NoAnswer(5.0), is_awaited=False).startswith("nobody waits with the number 4711: ")
    assert over_relay(NoAnswer(5.0)).startswith("nobody has answered for 5 s")
    with pytest.raises(NetworkError, match=r"the words are wrong: type the code .* \(conf call 4711-WORD-WORD-WORD\)"):
        over_relay(WrongCode(0, relay))
