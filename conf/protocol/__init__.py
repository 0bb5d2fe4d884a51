"""The protocol of a call without I/O and without a clock: every method that needs the time gets `now`, in seconds.

    sender = SenderConnection(SenderSession(code, address, os.urandom, now), parameters, now)
    receiver = ReceiverEndpoint(SessionServer(code, os.urandom))
    one_end_of_a_call = CallEndpoint(code=code, parameters=parameters, now=now, random=os.urandom, remote=address)

All accept datagrams with `receive_datagram(data, address, now)`, return them with `datagrams_to_send(now)` and
report with `next_event()`. `LoopbackCall` connects two ends in memory. WIRE.md describes every byte. The names below
are the public ones; they are imported when they are first used.
"""

from typing import TYPE_CHECKING

from conf.lazy import lazy_attributes

_SOURCES = {
    "CallEndpoint": "call_endpoint",
    "CallLeg": "call_leg",
    "Decoder": "codec.decoder",
    "Encoder": "codec.encoder",
    "LoopbackCall": "loopback",
    "MotionFrame": "messages",
    "ObjectSender": "portrait.object_sender",
    "PROFILES": "codec.profiles",
    "RateOptions": "rate_control.send_budget",
    "ReceiveLeg": "receive_leg",
    "ReceiverEndpoint": "receiver_endpoint",
    "SendLeg": "send_leg",
    "SenderConnection": "sender_connection",
    "SenderSession": "session.client",
    "SessionServer": "session.server",
    "StreamParameters": "messages",
    "VoiceFormat": "voice.formats",
    "VoiceMode": "rate_control.rate_levels",
    "VoicePacket": "voice.formats",
    "VoiceState": "voice.formats",
    "generate_code": "session.pairing_code",
}

if TYPE_CHECKING:
    from conf.protocol.call_endpoint import CallEndpoint as CallEndpoint
    from conf.protocol.call_leg import CallLeg as CallLeg
    from conf.protocol.codec.decoder import Decoder as Decoder
    from conf.protocol.codec.encoder import Encoder as Encoder
    from conf.protocol.codec.profiles import PROFILES as PROFILES
    from conf.protocol.loopback import LoopbackCall as LoopbackCall
    from conf.protocol.messages import MotionFrame as MotionFrame
    from conf.protocol.messages import StreamParameters as StreamParameters
    from conf.protocol.portrait.object_sender import ObjectSender as ObjectSender
    from conf.protocol.rate_control.rate_levels import VoiceMode as VoiceMode
    from conf.protocol.rate_control.send_budget import RateOptions as RateOptions
    from conf.protocol.receive_leg import ReceiveLeg as ReceiveLeg
    from conf.protocol.receiver_endpoint import ReceiverEndpoint as ReceiverEndpoint
    from conf.protocol.send_leg import SendLeg as SendLeg
    from conf.protocol.sender_connection import SenderConnection as SenderConnection
    from conf.protocol.session.client import SenderSession as SenderSession
    from conf.protocol.session.pairing_code import generate_code as generate_code
    from conf.protocol.session.server import SessionServer as SessionServer
    from conf.protocol.voice.formats import VoiceFormat as VoiceFormat
    from conf.protocol.voice.formats import VoicePacket as VoicePacket
    from conf.protocol.voice.formats import VoiceState as VoiceState
else:
    __getattr__ = lazy_attributes(__name__, _SOURCES)

__all__ = list(_SOURCES)
