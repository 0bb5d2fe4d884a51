"""What the events of a call's session mean for the person at this end."""

from conf.errors import NetworkError
from conf.protocol.address import RelayAddress, host_of
from conf.protocol.session.events import (
    AddressChanged,
    Connected,
    Event,
    LossReason,
    NoAnswer,
    Refused,
    SessionEnded,
    WrongCode,
)
from conf.protocol.session.handshake import Refusal

WRONG_WORDS = "the words are wrong: type the code as the other end shows it (conf call {nameplate}-WORD-WORD-WORD)"
NOBODY_WAITS = "nobody waits with the number {nameplate}: is the number right, and the relay the same? trying on"
WRONG_CODE = "the code is wrong: type it as the other end shows it (conf call HOST --code CODE)"
REFUSALS = {
    Refusal.LOCKED: "too many wrong codes: the other end listens again in {wait:.0f} s",
    Refusal.FULL: "the other end is in a call: try later",
    Refusal.BUSY: "the other end is busy: trying again in {wait:.0f} s",
    Refusal.IN_CALL: "the other end is in a call: trying again in {wait:.0f} s",
}
NO_ANSWER = (
    "nobody has answered for {seconds:.0f} s: is `conf call --listen` running there, of the same version? trying on"
)
OTHER = "the other end"
ENDED = {
    LossReason.HUNG_UP: "{name} has hung up",
    LossReason.IDLE: "{name} has not been heard for 30 s: the call is over",
    LossReason.REPLACED: "",  # after an outage; that there is a connection is said next
    LossReason.CLOSED: "",
    LossReason.EXHAUSTED: "",
}


def describe_event(event: Event, *, name: str, is_calling: bool, nameplate: str = "", is_awaited: bool = True) -> str:
    """Return what an event means, "" for nothing. Raises NetworkError when the call cannot go on.

    name : of the other participant, "" if unknown
    is_calling : whether this end has called
    nameplate : of a call over a relay, "" for a direct one; is_awaited : whether somebody waits with it
    """
    match event:
        case WrongCode() if is_calling:
            raise NetworkError(WRONG_WORDS.format(nameplate=nameplate) if nameplate else WRONG_CODE)
        case WrongCode(tries_left=left, address=RelayAddress()):
            return f"a wrong code: {left} more tries for now"
        case WrongCode(tries_left=left, address=address):
            return f"a wrong code from {host_of(address)}: {left} more tries for now"
        case Refused(refusal=refusal, wait_s=None):
            raise NetworkError(REFUSALS[refusal])
        case Refused(refusal=refusal, wait_s=wait):
            return REFUSALS[refusal].format(wait=wait)
        case Connected(address=address):
            return f"connected with {name or (OTHER if nameplate else host_of(address))}"
        case AddressChanged(address=RelayAddress()):
            return "the direct path has failed: the call goes over the relay"
        case AddressChanged() if nameplate:
            return "the call goes directly now"
        case AddressChanged(address=address):
            return f"{name or OTHER} has moved to {host_of(address)}"
        case NoAnswer() if not is_awaited:
            return NOBODY_WAITS.format(nameplate=nameplate)
        case NoAnswer(seconds=seconds):
            return NO_ANSWER.format(seconds=seconds)
        case SessionEnded(reason=reason):
            return ENDED[reason].format(name=name or OTHER)
        case _:
            return ""
