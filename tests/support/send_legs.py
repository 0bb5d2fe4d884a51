"""Sending halves without a session, and what they send."""

import pytest

from conf.protocol.call_leg import CallLeg
from conf.protocol.feedback import Report
from conf.protocol.messages import Body, Feedback
from conf.protocol.portrait.object_sender import ObjectSender
from conf.protocol.rate_control.rate_levels import VoiceMode
from conf.protocol.rate_control.send_budget import RateOptions
from conf.protocol.send_leg import SendLeg
from conf.protocol.voice.formats import VoicePacket
from conf.protocol.wire import decode_body, encode_body
from tests.protocol.motion.test_outbound import PARAMETERS


class Leg(SendLeg):
    """A sending half with the leg that hands it the bodies."""

    def __init__(
        self, now: float = 0.0, rate: RateOptions | None = None, portrait: ObjectSender | None = None, name: str = ""
    ) -> None:
        super().__init__(PARAMETERS, now, rate=rate, portrait=portrait, name=name)
        self.call = CallLeg(send=self)

    def receive_body(self, data: bytes, now: float) -> int | None:
        return self.call.receive_body(data, 0, 0, now)


def started(rate: RateOptions | None = None, portrait: ObjectSender | None = None) -> Leg:
    leg = Leg(rate=rate, portrait=portrait)
    leg.start(0.0)
    return leg


def portrait(size: int = 5000) -> ObjectSender:
    made = ObjectSender()
    made.send_object(0, bytes(size), priority=0)
    return made


def sent(leg: SendLeg, now: float) -> list[Body]:
    return [decode_body(outgoing.body) for outgoing in leg.bodies_to_send(now)]


def feedback(highest: int, *, missing: int = 0, lost: int = 0, refresh: bool = False) -> bytes:
    return encode_body(Feedback(Report(highest, missing, lost, 5, 0), refresh))


def acknowledge_all(leg: Leg, now: float, counter: int = 0, rtt_s: float = 0.0) -> int:
    """Send what is due, and acknowledge it a round trip later. Returns the next counter."""
    for outgoing in leg.bodies_to_send(now):
        leg.on_sent(counter, outgoing, now)
        counter += 1
    leg.receive_body(feedback(counter - 1), now + rtt_s)
    return counter


def talking(kbps: float | None = None, *, portrait: ObjectSender | None = None) -> Leg:
    leg = started(RateOptions(kbps=kbps, voice=VoiceMode.AUTOMATIC), portrait)
    say(leg, 0.0)
    return leg


def say(leg: Leg, now: float, timestamp: float | None = None) -> None:
    voice_format = leg.voice_format or pytest.fail("there is no voice")
    size = voice_format.nominal_bytes if not voice_format.fixed_size else -(-voice_format.frame_bits // 8)
    at = now if timestamp is None else timestamp
    leg.send_voice(VoicePacket(at, voice_format, (bytes(size),) * voice_format.frames), now)
