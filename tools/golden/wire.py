"""Write the golden bodies to tests/data/body_*.bin and the invalid payloads to payload_*.bin. The output is constant.

    python tools/golden/wire.py

tools/golden/codec.py writes valid payloads, tools/golden/session.py datagrams.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from conf.protocol.codec.decoder import MAX_PAYLOAD
from conf.protocol.codec.payload_header import PayloadHeader, code_header
from conf.protocol.codec.symbol_coder import SymbolWriter
from conf.protocol.feedback import Report
from conf.protocol.messages import (
    Body,
    Bye,
    Composite,
    Feedback,
    FurrowMessage,
    KeepAlive,
    MotionPayload,
    ParticipantMessage,
    PathAnswer,
    PathProbe,
    Presence,
    RoundTripMessage,
    StreamParameters,
    VoiceFormatMessage,
    VoicePayload,
    VoiceStateMessage,
)
from conf.protocol.participant.state import CameraState
from conf.protocol.session.paths.candidates import PathCandidates
from conf.protocol.voice.formats import VoiceFormat, VoicePacket, VoiceState
from conf.protocol.voice.packing import pack_frames
from conf.protocol.wire import MAX_BODY, encode_body

FOLDER = Path(__file__).resolve().parents[2] / "tests" / "data"


REPORT = Feedback(Report(highest=300, missing=5, lost=2, jitter_ms=12, ack_delay_ms=30), refresh=False)
CODEC2_700 = VoiceFormat("codec2", 700, 40, 3, fixed_size=True)
CODEC2_1200 = VoiceFormat("codec2", 1200, 40, 5, fixed_size=True, repeated=2)
OPUS = VoiceFormat("opus", 5500, 60, 1, fixed_size=False, repeated=1)
VOICE_FRAMES = {
    "voice_fixed": VoicePacket(0.0, CODEC2_700, (b"\x12\x34\x56\x70", b"\x89\xab\xcd\xe0", b"\xff\xff\xff\xf0")),
    "voice_variable": VoicePacket(0.0, OPUS, (b"\x0a\x0b\x0c", b"\x0d\x0e")),  # the second repeats the one before
}


def _frames(name: str) -> bytes:
    return pack_frames(VOICE_FRAMES[name].frames, VOICE_FRAMES[name].format)


BODIES: dict[str, Body] = {
    "parameters": StreamParameters(320, 240, 15.0, 50, (6.4, 4.2, 2.0, 5.1, 1.1), clock=12.345),
    "keep_alive": KeepAlive(3.25, Presence.NO_FACE),
    "report": REPORT,
    "report_refresh": Feedback(Report(highest=4, missing=0, lost=0, jitter_ms=200, ack_delay_ms=0), refresh=True),
    "round_trip": RoundTripMessage(80),
    "goodbye": Bye(),
    "motion": MotionPayload(77, b"\x01\x02\x03"),
    "furrows": FurrowMessage(5),
    "voice_format_fixed": VoiceFormatMessage(2, CODEC2_700),
    "voice_format_variable": VoiceFormatMessage(0, OPUS),
    "voice_format_repeated": VoiceFormatMessage(1, CODEC2_1200),
    "voice_fixed": VoicePayload(300, True, 2, _frames("voice_fixed")),
    "voice_variable": VoicePayload(303, False, 0, _frames("voice_variable")),
    "voice_state": VoiceStateMessage(VoiceState.SILENT, 62),
    "voice_state_muted": VoiceStateMessage(VoiceState.MUTED, 127),
    "participant": ParticipantMessage("Zoë", CameraState.OFF),
    "participant_withdrawn": ParticipantMessage("Zoë", CameraState.ON, is_portrait_withdrawn=True),
    "participant_head": ParticipantMessage("", CameraState.ON, head=3),
    "path_probe": PathProbe(bytes.fromhex("31415926 53589793")),
    "path_answer": PathAnswer(bytes.fromhex("31415926 53589793")),
    "path_candidates": PathCandidates(
        2, 1, True, (("198.51.100.7", 40000), ("10.1.0.2", 40000), ("2001:db8::7", 40000, 0, 0))
    ),
    "composite": Composite((REPORT, MotionPayload(77, b"\x01\x02\x03"), VoicePayload(303, False, 0, b"\x0a"))),
    "composite_long": Composite((MotionPayload(77, bytes(range(1, 50))), Bye())),
}
HEADERS = {
    "live": PayloadHeader("live", count=1, stride=1, age=2, second_reference=True),
    "narrow": PayloadHeader("narrow", count=3, stride=1, age=0, second_reference=False),
    "rich": PayloadHeader("rich", count=2, stride=2, age=7, second_reference=False),
}


def header_payload(name: str) -> bytes:
    """Return a payload that ends after its header."""
    writer = SymbolWriter(rd_lambda=0.0)
    code_header(writer, HEADERS[name])
    return writer.finish()


def valid() -> dict[str, bytes]:
    """Return the bytes of each body, by name."""
    return {name: encode_body(body) for name, body in BODIES.items()}


def invalid() -> dict[str, bytes]:
    """Return bodies that must be rejected, by error."""
    good = valid()
    parameters, report = good["parameters"], good["report"]
    return {
        "empty": b"",
        "too_long": bytes([0x80]) * (MAX_BODY + 1),
        "unknown_kind": b"\x0f" + parameters[1:],
        "parameters_truncated": parameters[:-1],
        "parameters_without_points": parameters.replace(b"\x32", b"\x00", 1),
        "parameters_width_0": parameters.replace(b"\xcd\x01\x40", b"\x00", 1),
        "parameters_negative_clock": parameters.replace(b"\xcd\x30\x39", b"\xff", 1),
        "keep_alive_presence_2": good["keep_alive"][:-1] + b"\x02",
        "report_in_an_array": report[:1] + b"\x95" + report[1:],
        "report_lost_more_than_sent": report[:5] + b"\xcd\x01\x2d" + report[6:],
        "report_with_a_tail": report + b"\x00",
        "round_trip_of_two_minutes": b"\x03\x91\xce\x00\x01\xd4\xc0",
        "goodbye_with_more": good["goodbye"] + b"\x00",
        "composite_truncated": good["composite"][:11],
        "composite_of_nine": b"\x10\x04" * 8 + b"\x04",
        "composite_in_front": b"\x12\x10\x04\x04\x04",
        "composite_of_length_0": b"\x07\x00\x04",
        "voice_without_data": good["voice_fixed"][:2],
        "voice_format_17": good["voice_format_fixed"][:2] + b"\x10" + good["voice_format_fixed"][3:],
        "voice_format_repeats_4_of_3": good["voice_format_fixed"][:-1] + b"\x09",
        "voice_format_without_name": b"\x08\x96\x02\xa0" + good["voice_format_fixed"][10:],
        "voice_state_2": b"\x09\x02" + good["voice_state"][2:],
        "voice_state_5": b"\x09\x05" + good["voice_state"][2:],
        "participant_without_camera": good["participant"][:1],
        "participant_name_too_long": good["participant"][:2] + b"x" * 33,
        "participant_name_cut": good["participant"][:-1],
        "path_probe_cut": good["path_probe"][:-1],
        "path_answer_with_a_tail": good["path_answer"] + b"\x00",
        "path_candidates_cut": good["path_candidates"][:-1],
        "path_candidates_of_nine": good["path_candidates"][:3] + b"\x90" + bytes(54),
        "path_candidates_revision_0": b"\x0e\x80" + good["path_candidates"][2:],
        "furrows_cut": good["furrows"][:-1],
        "furrows_with_a_tail": good["furrows"] + b"\x00",
        "voice_state_noise_128": good["voice_state"][:2] + b"\x80",
    }


def payloads() -> dict[str, bytes]:
    """Return payloads that a decoder without stored frames must reject, by error."""
    return {
        "padded": header_payload("narrow") + b"\x00",
        "too_long": b"\x01" * (MAX_PAYLOAD + 1),
        "missing_reference": header_payload("live"),
    }


def main() -> None:
    """Write the files."""
    for name, data in valid().items():
        (FOLDER / f"body_{name}.bin").write_bytes(data)
    for name, data in invalid().items():
        (FOLDER / f"body_invalid_{name}.bin").write_bytes(data)
    for name, data in payloads().items():
        (FOLDER / f"payload_invalid_{name}.bin").write_bytes(data)


if __name__ == "__main__":
    main()
