"""Golden bodies and invalid payloads: their bytes do not change and they decode as before."""

import pytest

from conf.errors import ProtocolError
from conf.protocol.codec.decoder import Decoder
from conf.protocol.codec.reference_frames import MissingReferenceError
from conf.protocol.messages import Composite, ParticipantMessage, VoicePayload
from conf.protocol.wire import decode_body
from tools.golden.wire import BODIES, FOLDER, invalid, payloads, valid


def files(prefix: str) -> dict[str, bytes]:
    return {path.stem.removeprefix(prefix): path.read_bytes() for path in sorted(FOLDER.glob(f"{prefix}*.bin"))}


INVALID, PAYLOADS = files("body_invalid_"), files("payload_invalid_")
VALID = {name: data for name, data in files("body_").items() if not name.startswith("invalid_")}


def test_the_golden_files_are_up_to_date() -> None:
    assert (VALID, INVALID, PAYLOADS) == (valid(), invalid(), payloads())


@pytest.mark.parametrize("name", VALID)
def test_a_golden_body_decodes_and_its_truncations_are_rejected(name: str) -> None:
    assert decode_body(VALID[name]) == BODIES[name]
    for size in range(len(VALID[name])):
        cut = VALID[name][:size]
        if cut[:1] > b"\x80" or (size > 2 and isinstance(BODIES[name], VoicePayload | Composite)):
            continue  # truncated motion and voice are an error of what decodes them
        if 2 <= size < 5 and isinstance(BODIES[name], ParticipantMessage):
            continue  # a shorter name is one, unless its last character is cut
        with pytest.raises(ProtocolError):
            decode_body(VALID[name][:size])


@pytest.mark.parametrize("name", INVALID)
def test_an_invalid_body_is_rejected(name: str) -> None:
    with pytest.raises(ProtocolError):
        decode_body(INVALID[name])


@pytest.mark.parametrize("name", PAYLOADS)
def test_an_invalid_payload_is_rejected_and_nothing_is_stored(name: str) -> None:
    decoder = Decoder()
    with pytest.raises(MissingReferenceError if name == "missing_reference" else ProtocolError):
        decoder.decode(PAYLOADS[name], 10)
    assert all(not list(references.numbers()) for references in decoder._references.values())
