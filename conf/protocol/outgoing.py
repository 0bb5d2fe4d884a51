"""Bodies on their way into datagrams: what the arrival of each means, and several packed into one datagram."""

from collections.abc import Sequence
from dataclasses import dataclass

from conf.protocol.messages import (
    FurrowMessage,
    ParticipantMessage,
    StreamParameters,
    VoiceFormatMessage,
    VoiceStateMessage,
)
from conf.protocol.wire import (
    BYE,
    FURROWS,
    KEEP_ALIVE,
    MAX_BODIES,
    MAX_BODY,
    MAX_INNER_BODY,
    MOTION_BIT,
    PARAMETERS,
    PARTICIPANT,
    PORTRAIT_ACK,
    PORTRAIT_CHUNK,
    REFRESH_REPORT,
    REPORT,
    ROUND_TRIP,
    VOICE_BIT,
    VOICE_FORMAT,
    VOICE_STATE,
    join_bodies,
)

_MOTION, _VOICE = MOTION_BIT, VOICE_BIT
# The order of bodies in a composite. The chunk may be long, and only the last body needs no length.
_ORDER = (
    REPORT,
    REFRESH_REPORT,
    PORTRAIT_ACK,
    PARAMETERS,
    ROUND_TRIP,
    PARTICIPANT,
    VOICE_FORMAT,
    VOICE_STATE,
    KEEP_ALIVE,
    FURROWS,
    _MOTION,
    _VOICE,
    BYE,
)
_RANKS = {kind: rank for rank, kind in enumerate((*_ORDER, PORTRAIT_CHUNK))}


@dataclass(frozen=True)
class OutgoingBody:
    """A body to seal and send, and what its arrival means.

    frame_numbers : of the frames of motion it carries
    parameters, voice_format, voice_state, participant, furrow : what it announces, if anything
    """

    body: bytes
    frame_numbers: tuple[int, ...] = ()
    parameters: StreamParameters | None = None
    voice_format: VoiceFormatMessage | None = None
    voice_state: VoiceStateMessage | None = None
    participant: ParticipantMessage | None = None
    furrow: FurrowMessage | None = None

    @property
    def kind(self) -> int:
        """The kind of the body: MOTION_BIT for any motion, VOICE_BIT for any voice."""
        first = self.body[0]
        return MOTION_BIT if first & MOTION_BIT else VOICE_BIT if first & VOICE_BIT else first


def group_bodies(bodies: Sequence[OutgoingBody]) -> list[list[OutgoingBody]]:
    """Return the same bodies in as few datagrams as possible, in the order of WIRE.md."""
    datagrams: list[list[OutgoingBody]] = []
    for body in sorted(bodies, key=lambda body: _RANKS[body.kind]):
        if datagrams and _fits(datagrams[-1], body):
            datagrams[-1].append(body)
        else:
            datagrams.append([body])
    return datagrams


def _fits(parts: Sequence[OutgoingBody], body: OutgoingBody) -> bool:
    size = sum(len(part.body) + 2 for part in parts) + len(body.body)
    return len(parts) < MAX_BODIES and len(parts[-1].body) <= MAX_INNER_BODY and size <= MAX_BODY


def join_outgoing(parts: Sequence[OutgoingBody]) -> OutgoingBody:
    """Return the bodies of one datagram as one."""
    if len(parts) == 1:
        return parts[0]
    return OutgoingBody(
        join_bodies([part.body for part in parts]),
        tuple(number for part in parts for number in part.frame_numbers),
        next((part.parameters for part in parts if part.parameters), None),
        next((part.voice_format for part in parts if part.voice_format), None),
        next((part.voice_state for part in parts if part.voice_state), None),
        next((part.participant for part in parts if part.participant), None),
        next((part.furrow for part in parts if part.furrow), None),
    )
