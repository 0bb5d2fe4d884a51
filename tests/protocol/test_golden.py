"""The golden bodies and payloads hold the wire still."""

import pytest

from conf.errors import ProtocolError
from conf.protocol.codec import Decoder, MissingReferenceError
from conf.protocol.messages import MotionPayload
from conf.protocol.wire import decode_body
from tools.golden.wire import BODIES, FOLDER, invalid, payloads, valid


def files(prefix: str) -> dict[str, bytes]:
    return {path.stem.removeprefix(prefix): path.read_bytes() for path in sorted(FOLDER.glob(f"{prefix}*.bin"))}


INVALID, PAYLOADS = files("body_invalid_"), files("payload_invalid_")
VALID = {name: data for name, data in files("body_").items() if not name.startswith("invalid_")}


def test_the_bytes_have_not_changed() -> None:
    assert (VALID, INVALID, PAYLOADS) == (valid(), invalid(), payloads())


@pytest.mark.parametrize("name", VALID)
def test_a_valid_body_means_what_it_meant_and_no_truncation_of_it_means_anything(name: str) -> None:
    assert decode_body(VALID[name]) == BODIES[name]
    for size in range(len(VALID[name])):
        if size and isinstance(BODIES[name], MotionPayload):
            continue  # its end is the payload's business
        with pytest.raises(ProtocolError):
            decode_body(VALID[name][:size])


@pytest.mark.parametrize("name", INVALID)
def test_an_invalid_body_is_refused(name: str) -> None:
    with pytest.raises(ProtocolError):
        decode_body(INVALID[name])


@pytest.mark.parametrize("name", PAYLOADS)
def test_an_invalid_payload_is_refused_and_nothing_is_remembered(name: str) -> None:
    decoder = Decoder()
    with pytest.raises(MissingReferenceError if name == "missing_reference" else ProtocolError):
        decoder.decode(PAYLOADS[name], 10)
    assert all(not list(history.numbers()) for history in decoder._references.values())
